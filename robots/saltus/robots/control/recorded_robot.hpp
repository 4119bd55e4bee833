// A robot that replays the readings of a recorded run, open loop, and compares the commands with
// the recorded ones.
#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "saltus/robots/control/link_controller.hpp"

namespace saltus::robots::control {

/// Replays the rows in the state `balance` of a table that ControlLog has written. Interpolates
/// missing readings, like the controller.
class RecordedRobot final : public Robot {
 public:
  /// Reads `file`. Throws InputError if the file is not such a table for these joints, or contains
  /// fewer than one in 30 readings.
  RecordedRobot(const std::filesystem::path& file, const std::vector<LinkJoint>& joints,
                double period);

  const Robot::Readings& read() const override { return readings_; }
  void write(const Robot::Commands& commands) override;
  std::string wait() override;
  double period() const override { return period_; }
  std::string name() const override { return "recorded"; }

  /// True after the last readings.
  bool is_over() const { return row_ + 1 >= rows_.size(); }
  /// Number of readings, including interpolated ones.
  long readings() const;
  /// Number of commands that were compared.
  long compared() const { return compared_; }
  /// Largest difference between a torque and the recorded one, Nm.
  double largest() const { return largest_; }
  const std::string& joint() const { return joint_; }  ///< joint of the largest difference
  double time() const { return time_; }                ///< time of the largest difference, s
  /// Root mean square of all differences, Nm.
  double rms() const;

 private:
  struct Row {
    long sequence = 0;
    Robot::Readings readings;
    VectorXd torques;
  };
  void show();

  std::vector<Row> rows_;
  std::vector<std::string> names_;
  double period_;
  std::size_t row_ = 0;  // the latest row that is not after the present readings
  long sequence_ = 0;
  Robot::Readings readings_;
  long compared_ = 0;
  double largest_ = 0.0, squares_ = 0.0, time_ = 0.0;
  std::string joint_;
};

}  // namespace saltus::robots::control
