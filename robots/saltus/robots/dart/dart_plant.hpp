// The robot simulated by DART.
#pragma once

#include <memory>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus {

/// DART's detectors of collisions.
enum class DartCollision { dart, fcl, bullet, ode };
/// DART's solvers of contact forces.
enum class DartLcp { dantzig, pgs };
/// DART bounds the two tangential forces of a contact one by one: its friction cone is a square
/// one. `box`: each at most friction times the normal force, together up to sqrt(2) times that.
/// `inscribed`: each at most 1 / sqrt(2) of it, so that of a foot that stands no direction has more
/// than Coulomb's law allows, and those along the axes less. That does not hold for single samples
/// of a foot that bounces or is being unloaded: bounds are from normal forces of a first pass,
/// which its final ones may be far below.
enum class DartFriction { box, inscribed };

/// The plant's options and those of DART alone.
struct DartOptions : PlantOptions {
  DartCollision collision = DartCollision::bullet;  ///< which detector
  DartLcp lcp = DartLcp::dantzig;                   ///< which solver
  DartFriction cone = DartFriction::box;            ///< shape of the friction cone
};

/// With `self_collision` bodies need their capsules (add_capsules), and detectors other than Bullet
/// and ODE, which know none, are refused with InputError.
__attribute__((visibility("default"))) std::unique_ptr<Plant> make_dart_plant(
    const FloatingRobot& robot, const DartOptions& options);

}  // namespace saltus
