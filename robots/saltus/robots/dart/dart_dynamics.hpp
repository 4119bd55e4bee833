// Equations of motion by DART.
#pragma once

#include <memory>

#include "saltus/robots/whole_body/dynamics_model.hpp"

namespace saltus {

/// Creates equations of motion by DART.
__attribute__((visibility("default"))) std::unique_ptr<DynamicsModel> make_dart_dynamics(
    const FloatingRobot& robot);

}  // namespace saltus
