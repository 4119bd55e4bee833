// Assessment of a whole-body run from the simulated state, not from measurements: motion of the
// feet, tilt, and distances to the limits of the robot.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus::walking {

struct RunLog;

/// Results that only whole-body runs have.
struct BodyVerdict {
  /// True if the robot recovered without a step: no fall, both soles within `standing_move` of
  /// their start, and the base within `standing_tilt` of its start.
  bool standing = false;
  double feet_moved = 0.0;  ///< largest distance of a sole's origin from its start, m
  double tilt_max = 0.0;    ///< angle between the vertical in the base and that at the start, rad;
  double tilt_end = 0.0;    ///< rotation about the vertical does not count
  Vec<double, 2> slip = Vec<double, 2>::Zero();      ///< largest sole_slip, left and right, m
  Vec<double, 2> slips_from{infinity, infinity};     ///< time at which the slip exceeds
                                                     ///< `planted_slip`, s
  Vec<double, 2> friction = Vec<double, 2>::Zero();  ///< largest friction_used
  /// Impulse beyond Coulomb friction on both feet, N s: integral of the positive part of the
  /// tangential force minus `RunLog::ground_friction` times the vertical force. Engines implement
  /// the friction law differently.
  double beyond_friction = 0.0;
  Vec<double, 2> force_peak = Vec<double, 2>::Zero();  ///< vertical, mean over wrench_filter, N
  double limit_margin = infinity;      ///< smallest distance of a joint from its limit, rad; < 0:
                                       ///< beyond it
  std::string limit_joint;             ///< joint with the smallest distance
  double limit_time = 0.0;             ///< time of the smallest distance, s
  double torque_limit_fraction = 0.0;  ///< share of the time in which a torque is at its limit
  double speed_ratio = 0.0;            ///< largest ratio of a joint speed to its limit
  std::string speed_joint;             ///< joint with the largest ratio
  double speed_time = 0.0;             ///< time of the largest ratio, s
  double over_speed = 0.0;             ///< longest time that a joint exceeds its speed limit, s
  double clearance = infinity;         ///< smallest distance of two limbs, m; < 0: they overlap;
                                       ///< infinite: no collision shapes
  std::string clearance_pair;          ///< names of these limbs
  double clearance_time = 0.0;         ///< time of the smallest distance, s

  /// True if any joint reached its limit.
  bool touches_joint_limit() const;
};

/// Largest motion of a standing foot, m, and largest tilt, rad.
inline constexpr double standing_move = 0.01, standing_tilt = 0.05;  // m, rad
inline constexpr double planted_slip = 0.01;                         // m, for `recovered`
inline constexpr double limit_touched = 1e-3;  // rad; a joint nearer than this is at its limit

/// Assesses a log with samples of the whole body. Limits are not checked if `RunLog::floating` has
/// no joints.
BodyVerdict judge_body(const RunLog& log);

/// JSON for the section "body" of summary.json.
nlohmann::ordered_json to_json(const BodyVerdict& verdict);

}  // namespace saltus::walking
