// Springs and backlash between the reducers and the joints, for simulations.
//
// The rotor of an elastic drive moves on its own. With the angle of the rotor theta (divided by the
// ratio), the joint position q, the torque of the motor less its friction u, the rotor inertia I,
// the stiffness k and the play b:
//
//   I ddtheta = u - tau,   tau = k (delta - sign(delta) b / 2) if |delta| > b / 2, else 0,
//   delta = theta - q.
//
// The engine applies tau to the joint. A stiff spring on a light foot oscillates faster than an
// explicit step can follow. Therefore tau is that at the end of the step (backward Euler method).
// With the step h and the torque s of the spring at the start of the step, elimination of theta
// gives
//
//   tau = s + h k_e (dtheta + h (u - s) / I - dq) - h^2 k_e ddq,   k_e = k / (1 + h^2 k / I).
//
// The last term acts like a rotor that moves with the joint and has the inertia h^2 k_e < I. The
// engine treats it as such, also in contacts, so any stiffness is stable. For k -> infinity the
// drive is a rigid one. Within the play tau and this inertia are zero.
//
// The method damps the spring: the damping ratio is half of the step times the frequency of the
// oscillation (rad/s).
#pragma once

#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Rotors and springs of the elastic drives. Joints with infinite stiffness are rigid: their
/// torques and rotor inertias pass unchanged. After construction nothing allocates.
class ElasticDrives {
 public:
  /// Uses FloatingRobot::Body::drive. `step` is the time step of the engine, s. Throws
  /// DefinitionError, naming the joint, for a stiffness that is not positive, for a negative
  /// backlash, for a backlash without a spring and for a spring without rotor inertia.
  ElasticDrives(const FloatingRobot& robot, double step);

  /// True if no drive is elastic.
  bool is_rigid() const { return springs_.empty(); }
  /// Discards the state. The next step begins with springs that carry the torques of the motors,
  /// and with rotors that move with the joints.
  void reset() { is_loaded_ = false; }
  /// Speeds of the rotors for these joint speeds, rad/s.
  const VectorXd& rotor_speeds(const VectorXd& dq);
  /// Begins a step of the engine. `torques` are those of the motors, less their friction. Returns
  /// the torques on the joints, Nm. They are right if the joints also have the rotors inertias().
  const VectorXd& begin_step(const VectorXd& q, const VectorXd& dq, const VectorXd& torques);
  /// Inertias of the rotors that move with the joints during the step, kg m^2.
  const VectorXd& inertias() const { return inertias_; }
  /// Moves the rotors, with the joint speeds at the end of the step, rad/s.
  void end_step(const VectorXd& dq);

 private:
  struct Spring {
    Eigen::Index joint;
    double rotor_inertia, stiffness, half_play;  // kg m^2, Nm/rad, rad
    double angle = 0.0, speed = 0.0;             // of the rotor, rad and rad/s
    double motor = 0.0, joint_speed = 0.0;       // at the start of the step, Nm and rad/s
  };
  std::vector<Spring> springs_;
  double step_;
  bool is_loaded_ = false;
  VectorXd speeds_, torques_, inertias_;  // rad/s, Nm, kg m^2
};

}  // namespace saltus::robots
