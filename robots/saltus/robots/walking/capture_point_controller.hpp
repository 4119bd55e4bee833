// Baseline controller: steps to the predicted capture point, without a prediction horizon.
#pragma once

#include <memory>

#include "saltus/robots/walking/contact_settings.hpp"
#include "saltus/robots/walking/planner.hpp"

namespace saltus::walking {

/// Gains of the capture-point controller.
struct CapturePointGains {
  double after_landing = 0.8;     ///< end of the CoM trajectory after the landing, s
  double com_stiffness = 50.0;    ///< 1/s^2
  double com_damping = 14.1;      ///< 1/s
  double momentum_damping = 5.0;  ///< 1/s
};

/// Momentum control as in section 2.1 of the paper, without a horizon. The CoM tracks a
/// minimum-jerk trajectory to the target by PD control of its position. Until the landing, the
/// trajectory is planned anew from the current state in every tick. Angular momentum is damped. One
/// quadratic program per tick gives the wrenches, with the same contact cones as the receding
/// horizon controller.
std::unique_ptr<Planner> make_capture_point_controller(
    const CapturePointGains& gains, const PlannerSettings& settings, const ContactSettings& contact,
    const RobotDescription& robot, const Scene& scene, const Schedule& contacts);

}  // namespace saltus::walking
