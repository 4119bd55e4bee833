// What a run on the whole body asked of the robot, judged from the truth and not from measurements:
// did its feet stay, did it keep upright, how near did it come to its limits?
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus::walking {

struct RunLog;

/// What is judged on the whole body alone.
struct BodyVerdict {
  /// Caught without a step: no fall, neither sole ever `standing_move` from where it was at the
  /// start, and the base never `standing_tilt` from its start.
  bool standing = false;
  double feet_moved = 0.0;  ///< largest distance of a sole's origin from its start, m
  double tilt_max = 0.0;    ///< angle of the vertical in the base against that at the start, rad;
  double tilt_end = 0.0;    ///< a turn about the vertical is none
  Vec<double, 2> slip = Vec<double, 2>::Zero();      ///< see sole_slip, left and right, largest, m
  Vec<double, 2> slips_from{infinity, infinity};     ///< when it passed `planted_slip`, s
  Vec<double, 2> friction = Vec<double, 2>::Zero();  ///< see friction_used, largest
  /// What the ground exerted beyond Coulomb's friction on both feet, N s: integral of the
  /// tangential force less `RunLog::ground_friction` times the vertical one, where that is
  /// positive. Engines keep the law in their own way.
  double beyond_friction = 0.0;
  Vec<double, 2> force_peak = Vec<double, 2>::Zero();  ///< vertical, mean over wrench_filter, N
  double limit_margin = infinity;  ///< least distance of a joint from its limit, rad; < 0: beyond
  std::string limit_joint;         ///< of that joint
  double limit_time = 0.0;         ///< and when, s
  double torque_limit_fraction = 0.0;  ///< of the time in which some torque is at its limit
  double speed_ratio = 0.0;            ///< largest speed of a joint over its limit
  std::string speed_joint;             ///< of that joint
  double speed_time = 0.0;             ///< and when, s
  double over_speed = 0.0;             ///< longest time that a joint is above its limit, s
  double clearance = infinity;         ///< least distance of two limbs, m; < 0: one in the other;
                                       ///< infinite: their shapes are not known
  std::string clearance_pair;          ///< of these
  double clearance_time = 0.0;         ///< and when, s

  /// Whether any joint came to its limit.
  bool touches_joint_limit() const;
};

/// How far a foot that stands may move, m, and tilt, rad.
inline constexpr double standing_move = 0.01, standing_tilt = 0.05;  // m, rad
inline constexpr double planted_slip = 0.01;                         // m, for `recovered`
inline constexpr double limit_touched = 1e-3;  // rad; nearer than this a joint is at its limit

/// Of a log with samples of the body. Without joints in `RunLog::floating` limits are not judged.
BodyVerdict judge_body(const RunLog& log);

/// For the section "body" of summary.json.
nlohmann::ordered_json to_json(const BodyVerdict& verdict);

}  // namespace saltus::walking
