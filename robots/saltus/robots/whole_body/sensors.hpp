// Simulated sensors of a robot: joint encoders, a gyroscope and an accelerometer at the origin of
// the base, force-torque sensors in the soles. Each has a rate, noise, a bias and a delay.
#pragma once

#include <vector>

#include "saltus/core/random.hpp"
#include "saltus/robots/whole_body/device_options.hpp"
#include "saltus/robots/whole_body/robot.hpp"
#include "saltus/robots/whole_body/sole_kinematics.hpp"

namespace saltus::robots {

/// One simulated device. It takes a value in every step of the engine and outputs delayed, noisy
/// samples.
class SensorDevice {
 public:
  /// Options of a device.
  struct Options {
    double rate, delay, resolution = 0.0;  // Hz, s, unit of the values (0: exact)
    VectorXd noise, bias;                  // standard deviations
    bool averages = false;                 // true: samples are means over the period
  };
  /// Rate and delay are rounded to whole steps of the engine (s).
  SensorDevice(Options options, double step, std::uint64_t seed);

  /// Draws the bias. Until the first sample, the reading is based on `value`.
  void reset(const VectorXd& value);
  /// Passes the current true value.
  void observe(const VectorXd& value);
  /// Latest reading.
  const VectorXd& reading() const { return reading_; }
  /// True if the reading arrived in this step.
  bool is_new() const { return is_new_; }

 private:
  void sample(const VectorXd& value);

  struct Sample {
    VectorXd value;
    long due = 0;  // step at which the sample arrives
  };
  Options options_;
  long period_, delay_, steps_ = 0;  // in steps of the engine
  std::uint64_t seed_;
  Random random_;
  VectorXd bias_, sum_, reading_;
  std::vector<Sample> waiting_;  // ring buffer of delayed samples
  std::size_t first_ = 0, count_ = 0;
  bool is_new_ = false;
};

/// All sensors of a robot. Does not allocate after construction.
class Sensors {
 public:
  /// `step` is the time step of the engine, s. Throws DefinitionError for a rate that is not
  /// positive, and for a noise, bias, resolution or delay that is negative or not finite.
  Sensors(const FloatingRobot& robot, const SensorOptions& options, double step);

  /// Starts at rest in this state.
  void reset(const WholeBodyState& state);
  /// Processes the state after a step of the engine. Wrenches are in world axes, as in
  /// WholeBodyEstimate::Contact.
  void observe(const WholeBodyState& state, const WholeBodyEstimate::Contact& left,
               const WholeBodyEstimate::Contact& right);
  /// Latest readings of all devices.
  const Robot::Readings& readings() const { return readings_; }

 private:
  void read();

  double step_;
  SoleKinematics soles_[2];
  SensorDevice encoder_, gyroscope_, accelerometer_, feet_[2];
  Eigen::Isometry3d base_;   // before the step
  Vec<double, 3> velocity_;  // velocity of its origin before the step
  VectorXd inertial_, wrench_;
  Robot::Readings readings_;
};

}  // namespace saltus::robots
