// What the robot's own sensors tell of it: encoders in the joints, a gyroscope and an accelerometer
// at the base's origin, six-axis force and torque in the soles. Each has its rate, noise, bias and
// delay.
#pragma once

#include <vector>

#include "saltus/core/random.hpp"
#include "saltus/robots/whole_body/plant.hpp"
#include "saltus/robots/whole_body/sensor_options.hpp"
#include "saltus/robots/whole_body/sole_kinematics.hpp"

namespace saltus {

/// The latest readings at hand.
struct SensorReadings {
  VectorXd q;                                                ///< rad
  Vec<double, 3> angular_velocity = Vec<double, 3>::Zero();  ///< rad/s, axes of the base
  Vec<double, 3> specific_force = Vec<double, 3>::Zero();    ///< m/s^2, axes of the base
  /// (force N | torque Nm about the origin of the contact frame), axes of the sole.
  Vec<double, 6> left = Vec<double, 6>::Zero(), right = Vec<double, 6>::Zero();
  bool has_new_positions = false;  ///< did `q` arrive in this step?
};

/// Of a device in whole steps of the engine, at least one, s.
double sample_period(double rate, double step);

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
  double period() const { return static_cast<double>(period_) * step_; }  ///< s

 private:
  void sample(const VectorXd& value);

  struct Sample {
    VectorXd value;
    long due = 0;  // step
  };
  Options options_;
  double step_;
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
  double encoder_period() const { return encoder_.period(); }  ///< s

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
