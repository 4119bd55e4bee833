// Assessment of a whole-body run from the simulated state, not from measurements: motion of the
// feet, tilt, and distances to the limits of the robot.
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "saltus/robots/walking/biped_problem.hpp"

namespace saltus::robots::walking {

/// Largest motion of a standing foot, m, and largest tilt, rad.
inline constexpr double standing_move = 0.01, standing_tilt = 0.05;  // m, rad
inline constexpr double planted_slip = 0.01;                         // m, for `recovered`
inline constexpr double limit_touched = 1e-3;  // rad; a joint nearer than this is at its limit

/// Assesses a log with samples of the whole body. Limits are not checked if `RunLog::floating` has
/// no joints.
Verdict::Body judge_body(const RunLog& log);

/// JSON for the section "body" of summary.json.
nlohmann::ordered_json to_json(const Verdict::Body& verdict);

}  // namespace saltus::robots::walking
