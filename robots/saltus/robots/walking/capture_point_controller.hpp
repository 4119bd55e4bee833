// The controller to compare with: steps to the predicted capture point, but does not look ahead.
#pragma once

#include <memory>

#include "saltus/robots/walking/contact_settings.hpp"
#include "saltus/robots/walking/planner.hpp"

namespace saltus::walking {

/// Of the controller without prediction.
struct CapturePointGains {
  double after_landing = 0.8;     ///< where the trajectory of the CoM ends, s
  double com_stiffness = 50.0;    ///< 1/s^2
  double com_damping = 14.1;      ///< 1/s
  double momentum_damping = 5.0;  ///< 1/s
};

/// Momentum control as in the paper's section 2.1, without a horizon: the CoM follows a minimum
/// jerk trajectory to the target, planned afresh from where it is in every tick until the landing,
/// by PD on position; angular momentum is damped; the wrenches are the solution of one quadratic
/// program per tick with the same contact cones as a receding horizon controller.
std::unique_ptr<Planner> make_capture_point_controller(
    const CapturePointGains& gains, const PlannerSettings& settings, const ContactSettings& contact,
    const RobotDescription& robot, const Scene& scene, const Schedule& contacts);

}  // namespace saltus::walking
