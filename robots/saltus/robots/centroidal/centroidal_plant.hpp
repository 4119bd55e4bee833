// What would the robot's centre of mass really do? The exact centroidal dynamics, integrated.
#pragma once

#include <memory>

#include "saltus/model/integrator.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus {

/// The untruncated nonlinear centroidal dynamics of a robot on two feet (see centroidal.hpp),
/// driven by wrenches in the axes of the soles and a push on the CoM. A foot that does not touch
/// the ground exerts nothing, whatever is commanded.
class CentroidalPlant {
 public:
  /// A foot of the plant.
  struct Foot {
    SoleFrame sole;           ///< where it stands
    bool in_contact = false;  ///< whether forces act there
  };

  /// `integrator` should be much tighter than the controller's.
  CentroidalPlant(double mass, const Vec<double, 9>& start, const IntegratorChoice& integrator);

  Foot left, right;  ///< both feet
  /// By its side.
  Foot& foot(Side side) { return side == Side::left ? left : right; }
  /// By its side.
  const Foot& foot(Side side) const { return side == Side::left ? left : right; }
  Vec<double, 3> push = Vec<double, 3>::Zero();  ///< on the CoM, world axes, N

  /// gamma: CoM m, its velocity m/s, angular momentum Nms.
  const Vec<double, 9>& state() const { return state_; }

  /// Integrates over `length` s with constant wrenches (left, right), each (fx, fy, fz, tx, ty, tz)
  /// in the axes of its sole, N and Nm. The feet must not change contact meanwhile. On failure the
  /// state stays as it was.
  IntegrationStatus advance(double length, const Vec<double, 12>& wrenches);

  /// Sum of the contact forces of a command as the ground would exert them, world axes, N.
  Vec<double, 3> contact_force(const Vec<double, 12>& wrenches) const;

 private:
  std::unique_ptr<Integrator> integrator_;
  Vec<double, 9> state_;
};

}  // namespace saltus
