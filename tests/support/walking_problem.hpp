// A cart that is pushed by two legs, one of them or both in contact: modes "left", "double",
// "right" and "flight" in any order, on a horizon of two phases.
#pragma once

#include <random>
#include <string>

#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::testing_support {

inline constexpr int walk_capacity = 6;
inline constexpr double walk_horizon = 1.0;  // s, 10 intervals

/// Knows four modes; event "goal", which a window names, must stay.
Schedule walking_schedule();

/// Feasible whatever the schedule and the start are: what binds states is soft.
MultipleShooting walking_problem(const Schedule& schedule, bool with_change_costs = true);

/// One edit at random around the time now; always possible, "goal" stays. Returns what it was.
std::string edit_at_random(Schedule& schedule, double now, std::mt19937& random);

}  // namespace saltus::testing_support
