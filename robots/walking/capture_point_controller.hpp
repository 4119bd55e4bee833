// The controller to compare with: steps to the predicted capture point, but does not look ahead.
#pragma once

#include <memory>

#include "saltus/robots/walking/planner.hpp"

namespace saltus::push_recovery {

/// Momentum control as in the paper's section 2.1, without a horizon: the CoM follows a minimum
/// jerk course from where it is when the step is decided to the target, by PD on position; angular
/// momentum is damped; the wrenches are the solution of one quadratic program per tick with the
/// same contact cones as the receding horizon controller.
std::unique_ptr<Planner> make_capture_point_controller(const Config& config,
                                                       const RobotDescription& robot,
                                                       const Scene& scene);

}  // namespace saltus::push_recovery
