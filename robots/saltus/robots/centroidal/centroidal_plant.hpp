// Simulation of the exact centroidal dynamics.
#pragma once

#include <memory>

#include "saltus/model/integrator.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus::robots {

/// Nonlinear centroidal dynamics of a robot on two feet (see centroidal.hpp), without truncation.
/// Inputs are wrenches in the axes of the soles and a push on the CoM. A foot off the ground exerts
/// no wrench, whatever the command.
class CentroidalPlant {
 public:
  /// A foot of the plant.
  struct Foot {
    SoleFrame sole;           ///< pose of the sole
    bool in_contact = false;  ///< true if wrenches act
  };

  /// `integrator` should have a much smaller tolerance than the controller's.
  CentroidalPlant(double mass, const Vec<double, 9>& start, const IntegratorChoice& integrator);

  Foot left, right;  ///< both feet
  /// The foot on the given side.
  Foot& foot(Side side) { return side == Side::left ? left : right; }
  /// The foot on the given side.
  const Foot& foot(Side side) const { return side == Side::left ? left : right; }
  Vec<double, 3> push = Vec<double, 3>::Zero();  ///< force on the CoM, world axes, N

  /// gamma: CoM m, its velocity m/s, angular momentum Nms.
  const Vec<double, 9>& state() const { return state_; }

  /// Integrates over `length` (s) with constant wrenches (left, right), each (fx, fy, fz, tx, ty,
  /// tz) in the axes of its sole, N and Nm. Contacts must not change meanwhile. On failure the
  /// state is unchanged.
  IntegrationStatus advance(double length, const Vec<double, 12>& wrenches);

  /// Sum of the contact forces of a command that the ground would exert, world axes, N.
  Vec<double, 3> contact_force(const Vec<double, 12>& wrenches) const;

 private:
  std::unique_ptr<Integrator> integrator_;
  Vec<double, 9> state_;
};

}  // namespace saltus::robots
