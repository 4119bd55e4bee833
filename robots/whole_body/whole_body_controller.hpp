// Joint torques from what is asked of momentum, feet and posture: one quadratic program per call.
//
// Unknowns: joint accelerations and the wrenches of the feet on the ground. The six equations of
// the free base give its acceleration, d2q and wrenches the torques, so that both are affine in the
// unknowns. Hard: torque limits and contact cones, which some accelerations always meet. Soft, at
// named prices: stance feet do not move, joints stay within limits. The rest is weighed.
#pragma once

#include <memory>
#include <optional>

#include "framework/qp/qp_result.hpp"
#include "robots/contact_cone.hpp"
#include "robots/whole_body/dynamics_model.hpp"

namespace saltus {

struct WholeBodyWeights {
  double linear_momentum = 1.0;    ///< per N^2
  double angular_momentum = 10.0;  ///< per (Nm)^2
  double posture = 0.1;            ///< per (rad/s^2)^2
  double swing_foot = 1000.0;      ///< per (m/s^2)^2 and (rad/s^2)^2
  double wrench = 1e-3;            ///< of the difference to the planned wrenches, per N^2, (Nm)^2
  double stance_price = 1e4;       ///< L1, per m/s^2 and rad/s^2
  double limit_price = 1e3;        ///< L1, per rad/s^2
};

struct WholeBodyGains {
  double posture = 100.0, posture_damping = 20.0;  ///< 1/s^2, 1/s
  double stance_damping = 50.0;  ///< 1/s, on what is left of a stance foot's twist
  double limit_horizon = 0.05;   ///< s, in which no joint may reach its limit
};

/// What is asked for; wrenches (fx, fy, fz, tx, ty, tz) in the axes of their sole.
struct WholeBodyTasks {
  bool left_stands = true, right_stands = true;
  Vec<double, 3> force = Vec<double, 3>::Zero();   ///< rate of linear momentum, N
  Vec<double, 3> torque = Vec<double, 3>::Zero();  ///< rate of angular momentum about the CoM, Nm
  Vec<double, 12> wrenches = Vec<double, 12>::Zero();  ///< planned, left and right
  /// Of the foot that does not stand: d twist / dt, (angular | linear), world axes.
  Vec<double, 6> swing_acceleration = Vec<double, 6>::Zero();
  VectorXd posture;  ///< rad
};

struct WholeBodyCommand {
  VectorXd torques;                                    ///< Nm, within their limits
  VectorXd joint_acceleration;                         ///< rad/s^2
  Vec<double, 12> wrenches = Vec<double, 12>::Zero();  ///< expected, axes of the soles
  QpStatus status = QpStatus::invalid_problem;
  int iterations = 0;
  double stance_slip =
      0.0;  ///< largest entry of a stance foot's acceleration that had to be given up
  double limit_excess = 0.0;  ///< rad/s^2 by which a joint limit is not respected
};

class WholeBodyController {
 public:
  WholeBodyController(const FloatingRobot& robot, const ContactConeOptions& left,
                      const ContactConeOptions& right, const WholeBodyWeights& weights = {},
                      const WholeBodyGains& gains = {});
  ~WholeBodyController();
  /// The model must be at `state`. Does not allocate. When the program is not solved the torques of
  /// the last call stay.
  const WholeBodyCommand& control(const DynamicsModel& model, const WholeBodyState& state,
                                  const WholeBodyTasks& tasks) noexcept;

 private:
  struct Program;
  std::unique_ptr<Program> program_;
};

}  // namespace saltus
