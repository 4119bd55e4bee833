// Interface of whole-body controllers: joint torques from tasks for momentum, feet and posture.
#pragma once

#include "saltus/qp/qp_result.hpp"
#include "saltus/robots/whole_body/dynamics_model.hpp"

namespace saltus {

/// Tasks of a whole-body controller. Wrenches are (fx, fy, fz, tx, ty, tz) in the axes of their
/// sole.
struct WholeBodyTasks {
  bool left_stands = true, right_stands = true;    ///< feet that may carry load
  Vec<double, 3> force = Vec<double, 3>::Zero();   ///< rate of linear momentum, N
  Vec<double, 3> torque = Vec<double, 3>::Zero();  ///< rate of angular momentum about the CoM, Nm
  Vec<double, 12> wrenches = Vec<double, 12>::Zero();  ///< planned wrenches, left and right
  /// Acceleration of the swing foot: d twist / dt, (angular | linear), world axes.
  Vec<double, 6> swing_acceleration = Vec<double, 6>::Zero();
  VectorXd posture;  ///< desired joint positions, rad
};

/// Torques, and diagnostics of their computation.
struct WholeBodyCommand {
  VectorXd torques;                                    ///< Nm, within their limits
  VectorXd joint_acceleration;                         ///< rad/s^2
  Vec<double, 12> wrenches = Vec<double, 12>::Zero();  ///< expected wrenches, axes of the soles
  QpStatus status = QpStatus::invalid_problem;         ///< status of the quadratic program
  int iterations = 0;                                  ///< iterations of the quadratic program
  double solve_seconds = 0.0;                          ///< processor time of the quadratic program
  double stance_slip = 0.0;   ///< largest entry of a stance foot's acceleration that remains
  double limit_excess = 0.0;  ///< violation of a joint limit, rad/s^2
  int torques_cut = 0;        ///< number of joints whose torque was cut to its limit
};

/// Computes joint torques that carry out tasks.
class WholeBodyController {
 public:
  virtual ~WholeBodyController() = default;
  /// Sets the posture in which the robot will stand. Limbs that are close to each other in it need
  /// no larger distance later.
  virtual void stand(const WholeBodyState&) {}
  /// Computes the torques. The model must be updated to `state`. Does not allocate. If the program
  /// is not solved, the torques of the last call are kept.
  virtual const WholeBodyCommand& control(const DynamicsModel& model, const WholeBodyState& state,
                                          const WholeBodyTasks& tasks) noexcept = 0;
};

}  // namespace saltus
