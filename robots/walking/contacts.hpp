// Which contacts hold, and when the next one begins: a schedule of modes and events that the loop
// edits while it runs. A planned landing is retimed, one that is late is held off, one that is felt
// is confirmed.
#pragma once

#include "saltus/core/bounds.hpp"
#include "saltus/ocp/schedule.hpp"

namespace saltus::walking {

// The modes, and the event between them.
inline constexpr const char* single_support = "single support";  ///< the stance foot alone
inline constexpr const char* double_support = "double support";
inline constexpr const char* impact = "impact";  ///< the swing foot lands

/// On the stance foot, until the swing foot lands at `landing`, s; infinite: no landing is due.
inline Schedule one_foot_then_two(double landing = infinity) {
  return Schedule({single_support, double_support}, {{impact, landing}});
}
inline Schedule two_feet_throughout() { return Schedule({double_support}, {}); }

/// Absolute time of the landing, s; infinite if none is due, -infinite if both feet stand anyhow.
inline double landing_time(const Schedule& contacts) {
  return contacts.contains(impact) ? contacts.time_of(impact) : -infinity;
}

}  // namespace saltus::walking
