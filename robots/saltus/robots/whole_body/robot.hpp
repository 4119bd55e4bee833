// Interface to a robot, simulated or real: sensors in, joint torques out. This file also defines
// the state of the whole body and the forces on its feet, which estimators compute from the
// readings.
#pragma once

#include <Eigen/Geometry>
#include <optional>
#include <string>

#include "saltus/core/types.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus::robots {

/// Positions and velocities of a FloatingRobot. Joints have the order of its bodies, see
/// FloatingRobot::joint_index().
struct WholeBodyState {
  Eigen::Isometry3d base = Eigen::Isometry3d::Identity();  ///< pose of the base in the world
  Vec<double, 6> base_twist = Vec<double, 6>::Zero();      ///< (angular rad/s | linear m/s of the
                                                           ///< base's origin), world axes
  VectorXd q;                                              ///< rad
  VectorXd dq;                                             ///< rad/s

  /// True if every number is finite.
  bool is_finite() const {
    return base.matrix().allFinite() && base_twist.allFinite() && q.allFinite() && dq.allFinite();
  }
};

/// State and contacts, either measured by ideal sensors or estimated.
struct WholeBodyEstimate {
  /// Force of the ground on a foot.
  struct Contact {
    bool touches = false;                            ///< True if forces act.
    Vec<double, 6> wrench = Vec<double, 6>::Zero();  ///< (force N | torque Nm about the origin of
                                                     ///< the contact frame), world axes
  };

  WholeBodyState state;  ///< state of base and joints
  Contact left, right;   ///< contacts of both feet

  /// Contact of one foot.
  const Contact& contact(Side side) const { return side == Side::left ? left : right; }
};

/// A robot that a BalanceController can drive by alternating calls of read(), write() and wait().
///
/// Every wait() lasts one period(): the controller counts calls, and the estimator integrates the
/// inertial sensors over one period per set of readings. A robot that has lost a set reports a
/// failure. The base has the frame of the root link of the URDF.
class Robot {
 public:
  /// Latest readings of all sensors.
  struct Readings {
    /// s, larger after every wait(). Any instant may be zero: the controller counts from start().
    double time = 0.0;
    VectorXd q;  ///< joint positions, rad, in the order of FloatingRobot::joint_index()
    /// True if `q` is new. Without ideal sensors this happens at the rate of
    /// SensorOptions::encoder, from which the estimator derives joint velocities.
    bool has_new_positions = false;
    /// rad/s, axes of the base, mean over the last period.
    Vec<double, 3> angular_velocity = Vec<double, 3>::Zero();
    /// Acceleration of the origin of the base minus that of gravity, m/s^2, axes of the base, mean
    /// over the last period. At rest it has the size of g and points upwards. An inertial sensor at
    /// another place or with other axes must be converted.
    Vec<double, 3> specific_force = Vec<double, 3>::Zero();
    /// Force of the ground on the foot: (force N | torque Nm about the origin of the contact
    /// frame), axes of the sole, as FloatingRobot::left_sole. A standing foot has a positive third
    /// entry.
    Vec<double, 6> left = Vec<double, 6>::Zero(), right = Vec<double, 6>::Zero();
    /// State and contacts from ideal sensors, which only simulations have. If set, the other
    /// readings are not used.
    std::optional<WholeBodyEstimate> ideal;
  };

  /// Commands to all joints. The torque of a motor is
  /// torques + stiffness (positions - q) + damping (velocities - dq), within its limits. Its
  /// controller computes the springs and dampers at its own rate. The positions advance with the
  /// velocities until the next command.
  struct Commands {
    VectorXd torques{};                  ///< Nm, in the order of FloatingRobot::joint_index()
    VectorXd positions{}, velocities{};  ///< rad, rad/s, same order; empty: `torques` alone
    VectorXd stiffness{}, damping{};     ///< Nm/rad, Nm s/rad; as many as positions
  };

  virtual ~Robot() = default;

  /// Latest sensor readings. The reference stays valid until the next wait().
  virtual const Readings& read() const = 0;
  /// Sets the commands that act until the next call.
  virtual void write(const Commands& commands) = 0;
  /// Waits for the next readings, one period() after the last ones. Returns an empty string, or one
  /// sentence on a failure.
  virtual std::string wait() = 0;
  /// Time between two readings, s.
  virtual double period() const = 0;
  /// Name for messages and results.
  virtual std::string name() const = 0;
};

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using WholeBodyState [[deprecated("use robots::WholeBodyState; removed in 0.4")]] =
    robots::WholeBodyState;
/// Deprecated name.
using FootContact [[deprecated("use robots::WholeBodyEstimate::Contact; removed in 0.4")]] =
    robots::WholeBodyEstimate::Contact;
}  // namespace saltus
