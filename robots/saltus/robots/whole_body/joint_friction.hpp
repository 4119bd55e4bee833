// Friction of the joints' drives, for simulations.
#pragma once

#include "saltus/core/types.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Viscous friction, and dry friction of bristles that bend until they slip (the elasto-plastic
/// form of Dahl's model). A joint at rest is held, because the bristles are springs. The torque at
/// which they slip falls with the speed (Stribeck's effect). After construction nothing allocates.
class JointFriction {
 public:
  /// Uses FloatingRobot::Body::drive. `step` is the time step of the engine, s. Throws
  /// DefinitionError, naming the joint, for figures that are negative or not finite, and for dry
  /// friction without rotor inertia, which the explicit step could not integrate.
  JointFriction(const FloatingRobot& robot, double step);

  /// True if no joint has friction.
  bool is_zero() const { return is_zero_; }
  /// Relaxes all bristles.
  void reset() { bent_.setZero(); }
  /// Advances by one step at these speeds, rad/s. Returns the torques that oppose the motion, Nm.
  const VectorXd& step(const VectorXd& dq);

 private:
  struct Joint {
    double viscous = 0.0, dry = 0.0, breakaway = 1.0, stribeck_speed = 1.0;
    double stiffness = 0.0, damping = 0.0;  // of the bristles, Nm/rad and Nm s/rad
  };
  std::vector<Joint> joints_;
  double step_;
  bool is_zero_ = true;
  VectorXd bent_, torques_;  // rad, Nm
};

}  // namespace saltus::robots
