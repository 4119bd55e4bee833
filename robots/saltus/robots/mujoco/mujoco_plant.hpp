// Simulation of the robot by MuJoCo, an engine with a different contact model from DART.
#pragma once

#include <memory>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus::robots {

/// True if this program was built with MuJoCo.
bool has_mujoco();

/// Creates the plant. Contacts have elliptic friction cones and are soft with a time constant of 5
/// ms. Boxes collide with the ground only. With `self_collision` the bodies need capsules
/// (add_capsules). A step that MuJoCo cannot compute leaves a state that is not finite, until
/// reset(). Throws InputError if MuJoCo rejects the robot, or if the program lacks MuJoCo.
std::unique_ptr<Plant> make_mujoco_plant(const FloatingRobot& robot, const Plant::Options& options);

/// Mass matrix of the robot by MuJoCo, as in DynamicsModel, to compare engines.
MatrixXd mujoco_mass_matrix(const FloatingRobot& robot, const WholeBodyState& state);

}  // namespace saltus::robots

namespace saltus {                 // deprecated names, removed in 0.4
using robots::has_mujoco;          ///< deprecated name
using robots::make_mujoco_plant;   ///< deprecated name
using robots::mujoco_mass_matrix;  ///< deprecated name
}  // namespace saltus
