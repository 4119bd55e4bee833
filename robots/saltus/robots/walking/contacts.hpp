// Which contacts hold, and when the next ones begin and end: a schedule of modes and events, made
// anew in every tick from the feet that stand and the steps to come.
#pragma once

#include <span>

#include "saltus/core/bounds.hpp"
#include "saltus/ocp/schedule.hpp"
#include "saltus/robots/walking/step_plan.hpp"

namespace saltus::walking {

// The modes, and the events between them.
inline constexpr const char* left_support = "left support";    ///< the left foot alone stands
inline constexpr const char* right_support = "right support";  ///< the right one
inline constexpr const char* double_support =
    "double support";                                ///< name of the mode in which both feet stand
inline constexpr const char* impact = "impact";      ///< the first landing to come
inline constexpr const char* lift_off = "lift-off";  ///< the first lift-off

/// The mode in which this foot stands alone.
inline const char* support_of(Side stance) {
  return stance == Side::left ? left_support : right_support;
}

/// Events within the horizon of a controller, for robots that step again and again: a landing and
/// the lift-off after it.
inline constexpr int events_ahead = 3;

/// On the stance foot, until the other one lands at `landing`, s; infinite: no landing is due.
/// Knows all modes and has room for so many events.
Schedule one_foot_then_two(double landing = infinity, Side stance = Side::left, int events = 1);
/// A schedule without a step, with room for so many events.
Schedule two_feet_throughout(int events = 0);

/// The contacts from now on: what stands, and as many of the steps to come as there is room for. A
/// foot in the air lands by the first of them. Does not allocate.
void schedule_contacts(Schedule& contacts, bool left_stands, bool right_stands,
                       std::span<const PlannedStep> steps);

/// Absolute time of the first landing, s; infinite if none is due, -infinite if both feet stand and
/// no step is planned.
double landing_time(const Schedule& contacts);

}  // namespace saltus::walking
