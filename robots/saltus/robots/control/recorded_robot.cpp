#include "saltus/robots/control/recorded_robot.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <fstream>

#include "saltus/core/csv_table.hpp"
#include "saltus/core/error.hpp"
#include "saltus/robots/control/control_process.hpp"

namespace saltus::robots::control {

RecordedRobot::RecordedRobot(const std::filesystem::path& file,
                             const std::vector<LinkJoint>& joints, double period)
    : names_(names_of(joints)), period_(period) {
  std::ifstream table(file);
  std::string line;
  if (!table || !std::getline(table, line))
    throw InputError(fmt::format("{}: there is no such file, or it is empty", file.string()));
  if (line != ControlTable(joints).header())
    throw InputError(fmt::format(
        "{}: it is not a log of `saltus control` for this robot; robot.yaml lists other joints",
        file.string()));
  const auto n = std::ssize(joints);
  while (std::getline(table, line)) {
    const std::vector<std::string> cells = csv_cells(line);
    if (cells.size() < 2 || cells[1] != "balance") continue;
    std::vector<double> numbers;
    for (std::size_t i = 2; i < cells.size(); ++i) {
      double value = NAN;
      std::from_chars(cells[i].data(), cells[i].data() + cells[i].size(), value);
      numbers.push_back(value);
    }
    if (std::ssize(numbers) != 3 + 3 * n + 18) continue;  // the last line may be incomplete
    const double* at = numbers.data() + 3;
    const auto next = [&at](std::ptrdiff_t count) {
      const Eigen::Map<const VectorXd> values(at, count);
      at += count;
      return values;
    };
    Row row;
    row.sequence = std::lround(numbers[0]);
    row.readings.q = next(n);
    next(n);
    row.torques = next(n);
    row.readings.angular_velocity = next(3);
    row.readings.specific_force = next(3);
    row.readings.left = next(6);
    row.readings.right = next(6);
    row.readings.has_new_positions = true;
    if (!rows_.empty() && row.sequence <= rows_.back().sequence) continue;
    rows_.push_back(std::move(row));
  }
  if (rows_.size() < 2)
    throw InputError(fmt::format("{}: it has no readings in the state balance", file.string()));
  if (readings() > 30 * std::ssize(rows_))
    throw InputError(fmt::format("{}: it has {} of {} readings; record with --log-every 1",
                                 file.string(), rows_.size(), readings()));
  sequence_ = rows_.front().sequence;
  show();
}

long RecordedRobot::readings() const { return rows_.back().sequence - rows_.front().sequence + 1; }

double RecordedRobot::rms() const {
  return compared_ > 0 ? std::sqrt(squares_ / static_cast<double>(compared_)) : 0.0;
}

void RecordedRobot::show() {
  while (row_ + 1 < rows_.size() && rows_[row_ + 1].sequence <= sequence_) ++row_;
  const Row& from = rows_[row_];
  readings_ = from.readings;
  if (from.sequence < sequence_ && row_ + 1 < rows_.size()) {
    const Row& to = rows_[row_ + 1];
    const double s = static_cast<double>(sequence_ - from.sequence) /
                     static_cast<double>(to.sequence - from.sequence);
    const auto between = [&](auto member) {
      (readings_.*member) = (1.0 - s) * (from.readings.*member) + s * (to.readings.*member);
    };
    between(&Robot::Readings::q);
    between(&Robot::Readings::angular_velocity);
    between(&Robot::Readings::specific_force);
    between(&Robot::Readings::left);
    between(&Robot::Readings::right);
  }
  readings_.time = static_cast<double>(sequence_ - rows_.front().sequence) * period_;
}

void RecordedRobot::write(const Robot::Commands& commands) {
  const Row& row = rows_[row_];
  if (row.sequence != sequence_ || is_over()) return;  // the soft stop comes at the end
  const VectorXd difference = commands.torques - row.torques;
  Eigen::Index worst = 0;
  const double most = difference.cwiseAbs().maxCoeff(&worst);
  squares_ += difference.squaredNorm() / static_cast<double>(difference.size());
  ++compared_;
  if (!(most <= largest_)) {
    largest_ = most;
    joint_ = names_[static_cast<std::size_t>(worst)];
    time_ = readings_.time;
  }
}

std::string RecordedRobot::wait() {
  if (is_over()) return {};
  ++sequence_;
  show();
  return {};
}

}  // namespace saltus::robots::control
