// The robot simulated by MuJoCo: a second engine, whose contacts work by other rules than DART's.
#pragma once

#include <memory>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus {

/// Was this program built with MuJoCo?
bool has_mujoco();

/// Contact: elliptic friction cones, soft with a time constant of 5 ms. Boxes collide with the
/// ground only; with `self_collision` bodies need their capsules (add_capsules). A step that MuJoCo
/// cannot compute leaves a state that is not finite, until reset(). Throws InputError when MuJoCo
/// refuses the robot, and when the program lacks MuJoCo.
std::unique_ptr<Plant> make_mujoco_plant(const FloatingRobot& robot, const PlantOptions& options);

/// What MuJoCo says of the same robot, to compare engines: the mass matrix as in DynamicsModel.
MatrixXd mujoco_mass_matrix(const FloatingRobot& robot, const WholeBodyState& state);

}  // namespace saltus
