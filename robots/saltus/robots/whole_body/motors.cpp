#include "saltus/robots/whole_body/motors.hpp"

#include <fmt/format.h>

#include <cmath>
#include <numbers>

#include "saltus/core/error.hpp"

namespace saltus::robots {

Motors::Motors(const MotorOptions& options, int joints, double step)
    : wanted_(VectorXd::Zero(joints)), torques_(wanted_), exerted_(wanted_) {
  const auto expect = [](bool good, const char* what, double value) {
    if (!good || !std::isfinite(value))
      throw DefinitionError(fmt::format("motors: {} must not be {}", what, value));
  };
  expect(options.bandwidth >= 0.0, "the bandwidth", options.bandwidth);
  expect(options.torque_rate >= 0.0, "the largest rate of torque", options.torque_rate);
  expect(step > 0.0, "the step", step);
  // Exact solution of the lag for a constant command during a step: the value at the end of the
  // step, and the mean, which is passed to the engine.
  if (options.bandwidth > 0.0) {
    const double lags = 2.0 * std::numbers::pi * options.bandwidth * step;
    followed_ = -std::expm1(-lags);
    mean_followed_ = 1.0 - followed_ / lags;
  }
  if (options.torque_rate > 0.0) largest_change_ = options.torque_rate * step;
}

void Motors::reset() {
  wanted_.setZero();
  torques_.setZero();
  exerted_.setZero();
  rests_ = true;
}

void Motors::command(const VectorXd& torques) {
  wanted_ = torques;
  if (rests_) torques_ = torques;
  rests_ = false;
}

const VectorXd& Motors::step() {
  for (int i = 0; i < torques_.size(); ++i) {
    const double missing = wanted_[i] - torques_[i], change = followed_ * missing;
    const bool is_limited = std::abs(change) > largest_change_;
    const double moved = is_limited ? std::copysign(largest_change_, change) : change;
    exerted_[i] = torques_[i] + (is_limited ? 0.5 * moved : mean_followed_ * missing);
    torques_[i] += moved;
  }
  return exerted_;
}

}  // namespace saltus::robots
