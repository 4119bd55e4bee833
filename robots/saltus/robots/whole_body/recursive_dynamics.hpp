// Equations of motion of a tree of bodies, without a physics engine.
#pragma once

#include <memory>

#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::robots {

/// Dynamics by recursion over the bodies: composite rigid bodies for the mass matrix, Newton and
/// Euler for the bias (Featherstone, Rigid Body Dynamics Algorithms, 2008, 6.2 and 5.3). Does not
/// allocate after construction.
std::unique_ptr<DynamicsModel> make_recursive_dynamics(const FloatingRobot& robot);

}  // namespace saltus::robots
