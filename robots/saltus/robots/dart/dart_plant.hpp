// Equations of motion of a robot, and its simulation, by DART.
#pragma once

#include <memory>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus::robots {

/// Creates equations of motion by DART.
__attribute__((visibility("default"))) std::unique_ptr<DynamicsModel> make_dart_dynamics(
    const FloatingRobot& robot);

/// Options of the plant and of DART.
struct DartOptions : Plant::Options {
  /// Collision detectors of DART.
  enum class Collision { dart, fcl, bullet, ode };

  /// Contact solvers of DART.
  enum class Lcp { dantzig, pgs };

  /// Friction cone. DART bounds the two tangential forces of a contact separately, which gives a
  /// square cone. `box`: each is at most friction times the normal force, and their resultant at
  /// most sqrt(2) times that. `inscribed`: each is at most 1 / sqrt(2) of it, so no direction
  /// exceeds Coulomb friction, but forces along the axes stay below it.
  ///
  /// `inscribed` does not hold for single samples of a foot that bounces or is being unloaded: the
  /// bounds use normal forces of a first pass, and the final ones may be much smaller.
  enum class Friction { box, inscribed };

  Collision collision = Collision::bullet;  ///< collision detector
  Lcp lcp = Lcp::dantzig;                   ///< contact solver
  Friction cone = Friction::box;            ///< shape of the friction cone
};

/// Creates the plant. With `self_collision` the bodies need capsules (add_capsules). Throws
/// InputError for detectors without capsules (all except Bullet and ODE).
__attribute__((visibility("default"))) std::unique_ptr<Plant> make_dart_plant(
    const FloatingRobot& robot, const DartOptions& options);

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using DartOptions [[deprecated("use robots::DartOptions; removed in 0.4")]] = robots::DartOptions;
/// Deprecated name.
using DartCollision [[deprecated("use robots::DartOptions::Collision; removed in 0.4")]] =
    robots::DartOptions::Collision;
/// Deprecated name.
using DartLcp [[deprecated("use robots::DartOptions::Lcp; removed in 0.4")]] =
    robots::DartOptions::Lcp;
using robots::make_dart_dynamics;  ///< deprecated name
using robots::make_dart_plant;     ///< deprecated name
}  // namespace saltus
