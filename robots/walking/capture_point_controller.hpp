// The controller to compare with: steps to the predicted capture point, but does not look ahead.
#pragma once

#include <memory>

#include "saltus/robots/walking/contact_settings.hpp"
#include "saltus/robots/walking/planner.hpp"

namespace saltus::walking {

/// Momentum control as in the paper's section 2.1, without a horizon: the CoM follows a minimum
/// jerk trajectory from where it is when the step is decided to the target, by PD on position;
/// angular momentum is damped; the wrenches are the solution of one quadratic program per tick with
/// the same contact cones as a receding horizon controller.
std::unique_ptr<Planner> make_capture_point_controller(const PlannerSettings& settings,
                                                       const ContactSettings& contact,
                                                       const RobotDescription& robot,
                                                       const Scene& scene);

}  // namespace saltus::walking
