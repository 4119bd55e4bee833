// Dynamics of a robot whose mass and centre of mass differ from its description, and their estimate
// from the forces of the ground.
//
// Momentum of a robot that only the ground touches, about a fixed point o:
//   dp_z/dt = F_z - m g,   dL/dt = T + m (c - o) x (0, 0, -g),
// with force F and torque T of the ground. Measured forces and the description of the robot leave
// residuals, which are errors of its weight m g and of its first moment m (c - o). The integral of
// these equations over a short time needs no accelerations.
#pragma once

#include <memory>

#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Options of the estimate of mass and CoM.
struct MassEstimateOptions {
  bool is_estimated = false;  ///< False: mass and CoM are those of the description.
  /// s: time constant of the estimate. It grows with the observed time from the shortest to the
  /// longest.
  double shortest = 0.2, longest = 1.0;
  /// s: forces count only if the robot stays quiet for this time after them. A push has no effect,
  /// because the robot moves soon after its start.
  double batch = 0.05;
  /// A robot is quiet if its CoM has been slow (m/s) and its angular momentum per mass small
  /// (m^2/s) for a time (s).
  double most_speed = 0.08, most_momentum = 0.01, rest = 0.15;
  double most_mass = 0.25;    ///< largest relative error of the mass
  double most_offset = 0.03;  ///< m, largest horizontal error of the CoM
};

/// Model of a robot with all masses and inertias times a factor, and with its CoM shifted
/// horizontally while the inertia about it stays. Nothing allocates after construction.
class CorrectedModel final : public DynamicsModel {
 public:
  /// Force of the ground on both feet, world axes.
  struct GroundForce {
    Vec<double, 3> force = Vec<double, 3>::Zero();   ///< N
    Vec<double, 3> torque = Vec<double, 3>::Zero();  ///< about the origin of the world, Nm
  };

  /// `model`: dynamics of `robot`, as described.
  CorrectedModel(std::unique_ptr<DynamicsModel> model, const FloatingRobot& robot,
                 const MassEstimateOptions& options);

  /// Returns to the described mass and CoM.
  void reset();
  /// Estimates mass and CoM. All forces of the ground act for `dt` (s) from the state of the last
  /// update() on.
  void observe(double dt, const GroundForce& ground);

  void update(const WholeBodyState& state) override;
  int joints() const override { return described_->joints(); }
  double mass() const override { return factor_ * described_->mass(); }
  /// Mass as a multiple of that of the description.
  double mass_factor() const { return factor_; }
  /// Shift of the CoM, m, axes of the base.
  const Vec<double, 3>& com_shift() const { return shift_; }

 private:
  using Sums = Vec<double, 3>;  // vertical force or momentum; horizontal torque or angular momentum

  bool is_quiet(double dt);
  Sums momentum() const;
  void correct(const Sums& residual, double dt);

  std::unique_ptr<DynamicsModel> described_;
  MassEstimateOptions options_;
  VectorXd rotor_inertia_;  // kg m^2, not scaled
  double factor_ = 1.0;
  Vec<double, 3> shift_ = Vec<double, 3>::Zero();
  Mat<double, 3, 3> base_ = Mat<double, 3, 3>::Identity();  // rotation
  Vec<double, 3> point_ = Vec<double, 3>::Zero();           // o
  Sums last_ = Sums::Zero(), recent_ = Sums::Zero(), pending_ = Sums::Zero();
  double quiet_ = 0.0, since_ = 0.0, observed_ = 0.0;  // s
  bool is_observing_ = false, is_pending_ = false;
};

}  // namespace saltus::robots
