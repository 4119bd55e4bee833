// Commissioning of a hanging robot: moves one joint after the other slightly, and reports faults.
#pragma once

#include <string>
#include <vector>

#include "saltus/robots/control/robot_control.hpp"

namespace saltus::robots::control {

/// Moves joints one after the other. First a torque without a spring grows in small steps until the
/// joint moves. This shows the delay and the signs, because a spring on a joint with a wrong sign
/// of position or velocity is unstable. If both are right, a spring then moves the joint by a small
/// angle and back, and holds it. All other joints are free. Does not allocate in update().
class JointCheck final : public LinkController {
 public:
  /// Sizes of the motions.
  struct Options {
    double torque = 0.1;   ///< largest torque without spring, as a fraction of the largest
    double moved = 0.01;   ///< motion that shows the sign, rad
    double angle = 0.05;   ///< motion by the spring, at most, rad
    double offset = 0.01;  ///< distance from the known posture that is reported as wrong, rad
  };
  /// Result for one joint.
  struct Report {
    bool is_checked = false;      ///< False if the program ended before this joint.
    double offset = 0.0;          ///< first position minus LinkJoint::start, rad
    double room = infinity;       ///< distance to the nearer limit, rad
    int sign = 0;                 ///< 1: moves along the torque, -1: against it, 0: does not move
    double torque = 0.0;          ///< torque at which it moved, Nm
    double delay = 0.0;           ///< time from this torque to the first measured motion, s
    double followed = 0.0;        ///< fraction of the commanded motion
    double velocity_ratio = 0.0;  ///< integral of the velocities over the change of the position
    /// Description of each fault. Empty if the joint passed.
    std::vector<std::string> findings = {};
  };

  /// Uses the springs and the period of `options`.
  JointCheck(std::vector<LinkJoint> joints, const ControlOptions& options, Options check);

  void start(const SensorMessage& readings) override;
  const Robot::Commands& update(double time, const SensorMessage& readings) override;
  bool is_done() const override { return joint_ >= std::ssize(joints_); }
  ControlState state() const override { return ControlState::check; }

  /// Reports of all joints, with findings.
  std::vector<Report> reports() const;
  /// Number of readings that were used. Without any, the two means are not numbers.
  long updates() const { return updates_; }
  /// Mean size of the specific force, m/s^2.
  double gravity() const { return gravity_ / static_cast<double>(updates_); }
  /// Mean size of the angular velocity, rad/s.
  double turning() const { return turning_ / static_cast<double>(updates_); }

 private:
  enum class Stage { rest, push, back, move, stay, home };
  void enter(Stage stage, double time);
  void next_joint(double time);
  void hold(double position);
  void release();

  std::vector<LinkJoint> joints_;
  ControlOptions options_;
  Options check_;
  std::vector<Report> reports_;
  Robot::Commands commands_;
  std::ptrdiff_t joint_ = 0;
  Stage stage_ = Stage::rest;
  double begin_ = 0.0, level_at_ = 0.0;     // start of the stage, and of this level of torque, s
  double lowest_ = 0.0, highest_ = 0.0;     // positions at rest, rad
  double fastest_ = 0.0;                    // speed at rest, rad/s
  double still_since_ = 0.0, place_ = 0.0;  // at rest
  double direction_ = 1.0, angle_ = 0.0;    // of the motion
  double from_ = 0.0, travelled_ = 0.0;     // position and integral of the velocity of a motion
  int level_ = 0;
  bool has_begun_ = false;
  double gravity_ = 0.0, turning_ = 0.0;
  long updates_ = 0;
};

}  // namespace saltus::robots::control
