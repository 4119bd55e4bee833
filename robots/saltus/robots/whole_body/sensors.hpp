// Simulated sensors of a robot: joint encoders, a gyroscope and an accelerometer at the origin of
// the base, force-torque sensors in the soles. Each has a rate, noise, a bias and a delay.
#pragma once

#include <vector>

#include "saltus/core/random.hpp"
#include "saltus/robots/whole_body/robot.hpp"
#include "saltus/robots/whole_body/sensor_options.hpp"
#include "saltus/robots/whole_body/sole_kinematics.hpp"

namespace saltus {

/// One device: takes a value in every step of the engine, hands over what it has measured.
class SensorDevice {
 public:
  /// Of one device.
  struct Options {
    double rate, delay, resolution = 0.0;  // Hz, s, of the values (0: none)
    VectorXd noise, bias;                  // standard deviations
    bool averages = false;                 // over the period
  };
  /// Rate and delay are rounded to whole steps of the engine (s).
  SensorDevice(Options options, double step, std::uint64_t seed);

  /// Draws the bias; up to the first sample `value` is what is measured.
  void reset(const VectorXd& value);
  /// What there is to measure now.
  void observe(const VectorXd& value);
  /// The latest.
  const VectorXd& reading() const { return reading_; }
  /// Whether it arrived in this step.
  bool is_new() const { return is_new_; }

 private:
  void sample(const VectorXd& value);

  struct Sample {
    VectorXd value;
    long due = 0;  // step
  };
  Options options_;
  long period_, delay_, steps_ = 0;  // of the engine
  std::uint64_t seed_;
  Random random_;
  VectorXd bias_, sum_, reading_;
  std::vector<Sample> waiting_;  // a ring of samples under way
  std::size_t first_ = 0, count_ = 0;
  bool is_new_ = false;
};

/// All of them. After construction nothing allocates.
class Sensors {
 public:
  /// `step` of the engine, s. Throws DefinitionError for a rate that is not positive, and for a
  /// noise, bias, resolution or delay that is negative or not finite.
  Sensors(const FloatingRobot& robot, const SensorOptions& options, double step);

  /// At rest in this state.
  void reset(const WholeBodyState& state);
  /// After a step of the engine; wrenches in world axes, as in FootContact.
  void observe(const WholeBodyState& state, const FootContact& left, const FootContact& right);
  /// The latest of all devices.
  const SensorReadings& readings() const { return readings_; }

 private:
  void read();

  double step_;
  SoleKinematics soles_[2];
  SensorDevice encoder_, gyroscope_, accelerometer_, feet_[2];
  Eigen::Isometry3d base_;   // before the step
  Vec<double, 3> velocity_;  // of its origin, the same
  VectorXd inertial_, wrench_;
  SensorReadings readings_;
};

}  // namespace saltus
