// Settling times of the vertical forces of the feet, by which the paper compares controllers.
//
// A force f has settled at the first instant after which |f - mean| stays within 5 % of the robot's
// weight, where the mean is that of f over the last second of the run. The settling time is
// measured from the last landing or push (Verdict::settled_from). It is infinite without a landing,
// if the run was stopped early, and if the force leaves the band within the last second.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <span>

#include "saltus/robots/walking/run_log.hpp"

namespace saltus::robots::walking {

inline constexpr double force_settled_within = 0.05;  ///< relative to the weight of the robot
inline constexpr double force_settled_over = 1.0;  ///< time span of the mean at the end of the run,
                                                   ///< s

/// Settling times of left and right foot, in s from the last landing or push.
struct ForceSettling {
  Vec<double, 2> planned{infinity, infinity};   ///< forces planned by MPC or baseline
  Vec<double, 2> measured{infinity, infinity};  ///< forces averaged over 20 ms; whole body only
};

/// Time from `begin` (s) until a signal, held between samples, stays within `band` of its mean over
/// the last second. Zero if it never leaves. Throws DefinitionError if the numbers of times and
/// values differ.
double settling_time(std::span<const double> times, std::span<const double> values, double begin,
                     double band);

/// Settling times of planned and measured forces, from `from` (s) on.
ForceSettling force_settling(const RunLog& log, double from);

/// JSON with "planned_left_s", ..., "measured_right_s"; null: not settled.
nlohmann::ordered_json to_json(const ForceSettling& settling);

}  // namespace saltus::robots::walking
