// The robot simulated by DART.
#pragma once

#include <memory>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus {

enum class DartCollision { dart, fcl, bullet, ode };
enum class DartLcp { dantzig, pgs };

struct DartOptions : PlantOptions {
  DartCollision collision = DartCollision::bullet;
  DartLcp lcp = DartLcp::dantzig;
};

/// With `self_collision` bodies need their capsules (add_capsules), and detectors other than Bullet
/// and ODE, which know none, are refused with InputError.
__attribute__((visibility("default"))) std::unique_ptr<Plant> make_dart_plant(
    const FloatingRobot& robot, const DartOptions& options);

}  // namespace saltus
