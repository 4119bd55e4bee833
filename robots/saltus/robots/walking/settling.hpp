// When do the vertical forces of the feet settle once all has happened? The paper compares
// controllers by that.
//
// A force f has settled at the first instant from which on |f - mean| stays within 5 % of the
// robot's weight, where the mean is that of f over the last second of the run. What is given is the
// time from an instant to there, that of the last landing or push (Verdict::settled_from); infinite
// without a landing, if the run was stopped early, and if the force leaves the band within that
// last second.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "saltus/robots/walking/run_log.hpp"

namespace saltus::walking {

inline constexpr double force_settled_within = 0.05;  ///< of the robot's weight
inline constexpr double force_settled_over = 1.0;     ///< the mean is that of this last span, s

/// Left and right foot, s from the last landing or push.
struct ForceSettling {
  Vec<double, 2> planned{infinity, infinity};   ///< by the planner: MPC or baseline
  Vec<double, 2> measured{infinity, infinity};  ///< mean over 20 ms; of the whole body only
};

/// Time from `begin` (s) until a signal, held from sample to sample, stays within `band` of its
/// mean over the last second; 0 if it never leaves. Throws DefinitionError unless there are as many
/// times as values.
double settling_time(std::span<const double> times, std::span<const double> values, double begin,
                     double band);

/// Of planned and measured forces, counted from `from`, s.
ForceSettling force_settling(const RunLog& log, double from);

/// "planned_left_s", ..., "measured_right_s"; null: never.
nlohmann::ordered_json to_json(const ForceSettling& settling);

}  // namespace saltus::walking
