// Contact schedule of a biped: modes and events, updated in every tick from the present support and
// the planned steps.
#pragma once

#include <span>

#include "saltus/core/bounds.hpp"
#include "saltus/ocp/schedule.hpp"
#include "saltus/robots/walking/step_planner.hpp"

namespace saltus::robots::walking {

// Names of the modes and of the events between them.
inline constexpr const char* left_support = "left support";      ///< only the left foot stands
inline constexpr const char* right_support = "right support";    ///< only the right foot stands
inline constexpr const char* double_support = "double support";  ///< both feet stand
inline constexpr const char* impact = "impact";                  ///< the next landing
inline constexpr const char* lift_off = "lift-off";              ///< the next lift-off

/// Name of the mode in which only this foot stands.
inline const char* support_of(Side stance) {
  return stance == Side::left ? left_support : right_support;
}

/// Events within the horizon of a controller for repeated steps: a landing and the next lift-off.
inline constexpr int events_ahead = 3;

/// Schedule with one stance foot, until the other one lands at `landing` (s); infinite: no landing
/// is due. Contains all modes and has capacity for `events` events.
Schedule one_foot_then_two(double landing = infinity, Side stance = Side::left, int events = 1);
/// Schedule without a step, with capacity for `events` events.
Schedule two_feet_throughout(int events = 0);

/// Updates the contacts from now on: present support, and as many planned steps as fit. A foot in
/// the air lands with the first of them. Does not allocate.
void schedule_contacts(Schedule& contacts, bool left_stands, bool right_stands,
                       std::span<const StepPlan::Step> steps);

/// Absolute time of the first landing, s; infinite if none is due, -infinite if both feet stand and
/// no step is planned.
double landing_time(const Schedule& contacts);

}  // namespace saltus::robots::walking
