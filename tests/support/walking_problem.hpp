// A cart that two legs push, with one leg or both in contact. The modes "left", "double", "right"
// and "flight" occur in any order, on a horizon of two phases.
#pragma once

#include <random>
#include <string>

#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::testing_support {

inline constexpr int walk_capacity = 6;
inline constexpr double walk_horizon = 1.0;  // s, 10 intervals

/// Schedule with four modes. A window names the event "goal", so that it must stay.
Schedule walking_schedule();

/// Feasible for every schedule and start, because limits on states are soft.
MultipleShooting walking_problem(const Schedule& schedule, bool with_change_costs = true);

/// Makes one random edit around the time now. An edit is always possible, and "goal" stays. Returns
/// a description of the edit.
std::string edit_at_random(Schedule& schedule, double now, std::mt19937& random);

}  // namespace saltus::testing_support
