// Joint torques from what is asked of momentum, feet and posture, whichever method finds them.
#pragma once

#include "saltus/qp/qp_result.hpp"
#include "saltus/robots/whole_body/dynamics_model.hpp"

namespace saltus {

/// What is asked for; wrenches (fx, fy, fz, tx, ty, tz) in the axes of their sole.
struct WholeBodyTasks {
  bool left_stands = true, right_stands = true;    ///< that may bear forces
  Vec<double, 3> force = Vec<double, 3>::Zero();   ///< rate of linear momentum, N
  Vec<double, 3> torque = Vec<double, 3>::Zero();  ///< rate of angular momentum about the CoM, Nm
  Vec<double, 12> wrenches = Vec<double, 12>::Zero();  ///< planned, left and right
  /// Of the foot that does not stand: d twist / dt, (angular | linear), world axes.
  Vec<double, 6> swing_acceleration = Vec<double, 6>::Zero();
  VectorXd posture;  ///< rad
};

/// Torques, and how they were found.
struct WholeBodyCommand {
  VectorXd torques;                                    ///< Nm, within their limits
  VectorXd joint_acceleration;                         ///< rad/s^2
  Vec<double, 12> wrenches = Vec<double, 12>::Zero();  ///< expected, axes of the soles
  QpStatus status = QpStatus::invalid_problem;         ///< of the quadratic program
  int iterations = 0;                                  ///< of the quadratic program
  double solve_seconds = 0.0;                          ///< processor time of the program's solution
  double stance_slip =
      0.0;  ///< largest entry of a stance foot's acceleration that had to be given up
  double limit_excess = 0.0;  ///< rad/s^2 by which a joint limit is not respected
  int torques_cut = 0;        ///< joints whose torque was found too large and cut to its limit
};

/// Torques that carry out tasks.
class WholeBodyController {
 public:
  virtual ~WholeBodyController() = default;
  /// The posture in which the robot will stand: what is close there need not keep further off.
  virtual void stand(const WholeBodyState&) {}
  /// The model must be at `state`. Does not allocate. When the program is not solved the torques of
  /// the last call stay.
  virtual const WholeBodyCommand& control(const DynamicsModel& model, const WholeBodyState& state,
                                          const WholeBodyTasks& tasks) noexcept = 0;
};

}  // namespace saltus
