// Interface to the equations of motion of a FloatingRobot.
#pragma once

#include "saltus/robots/whole_body/floating_robot.hpp"
#include "saltus/robots/whole_body/whole_body_state.hpp"

namespace saltus {

/// Motion of a sole. With nu of DynamicsModel, twist = J nu and d twist / dt = J dnu/dt + drift.
/// Twists are (angular | linear of the contact frame's origin), world axes.
struct SoleMotion {
  Eigen::Isometry3d pose;  ///< of the contact frame in the world
  Vec<double, 6> twist;    ///< (angular rad/s | linear m/s of its origin), world axes
  MatrixXd jacobian;       ///< 6 x (6 + n)
  Vec<double, 6> drift;    ///< (dJ/dt) nu
};

/// Equations of motion M dnu/dt + h = (0 | tau) + sum_i J_i' w_i. Here nu = (base twist | dq), with
/// the base twist as in WholeBodyState but in the base's own axes. w_i = (torque about the contact
/// frame's origin | force), world axes. All quantities belong to the state of the last update(),
/// which does not allocate.
class DynamicsModel {
 public:
  virtual ~DynamicsModel() = default;
  /// Computes all quantities at this state.
  virtual void update(const WholeBodyState& state) = 0;

  /// Number of joints.
  virtual int joints() const = 0;
  /// Mass of the whole robot, kg.
  virtual double mass() const = 0;
  const MatrixXd& mass_matrix() const { return mass_matrix_; }  ///< (6 + n) x (6 + n)
  const VectorXd& bias() const { return bias_; }  ///< h: gravity, Coriolis, centrifugal; 6 + n
  /// Motion of the sole on the given side.
  const SoleMotion& sole(Side side) const { return side == Side::left ? left_ : right_; }
  const Vec<double, 3>& com() const { return com_; }                    ///< m
  const Vec<double, 3>& com_velocity() const { return com_velocity_; }  ///< m/s
  const Vec<double, 3>& angular_momentum() const { return momentum_; }  ///< about the CoM, Nms

 protected:
  MatrixXd mass_matrix_;                          ///< (6 + joints) square
  VectorXd bias_;                                 ///< gravity and velocity terms, 6 + joints
  SoleMotion left_, right_;                       ///< motion of both soles
  Vec<double, 3> com_, com_velocity_, momentum_;  ///< m, m/s, Nms about the CoM
};

}  // namespace saltus
