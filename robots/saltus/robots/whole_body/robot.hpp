// Interface to a robot, simulated or real: sensors in, joint torques out.
#pragma once

#include <optional>
#include <string>

#include "saltus/robots/whole_body/whole_body_state.hpp"

namespace saltus {

/// Latest readings of all sensors.
struct SensorReadings {
  double time = 0.0;                                         ///< s
  VectorXd q;                                                ///< joint positions, rad
  bool has_new_positions = false;                            ///< True if `q` is new.
  Vec<double, 3> angular_velocity = Vec<double, 3>::Zero();  ///< rad/s, axes of the base
  Vec<double, 3> specific_force = Vec<double, 3>::Zero();    ///< m/s^2, axes of the base
  /// (force N | torque Nm about the origin of the contact frame), axes of the sole.
  Vec<double, 6> left = Vec<double, 6>::Zero(), right = Vec<double, 6>::Zero();
  /// State and contacts from ideal sensors, which only simulations have. If set, the other readings
  /// are not used.
  std::optional<WholeBodyEstimate> ideal;
};

/// Commands to all joints.
struct JointCommands {
  VectorXd torques;  ///< Nm
};

/// A robot that a BalanceController can drive by alternating calls of read(), write() and wait().
class Robot {
 public:
  virtual ~Robot() = default;

  /// Latest sensor readings. The reference stays valid until the next wait().
  virtual const SensorReadings& read() const = 0;
  /// Sets the commands that act until the next call.
  virtual void write(const JointCommands& commands) = 0;
  /// Waits for the next readings. Returns an empty string, or one sentence on a failure.
  virtual std::string wait() = 0;
  /// Time between two readings, s.
  virtual double period() const = 0;
  /// Name for messages and results.
  virtual std::string name() const = 0;
};

}  // namespace saltus
