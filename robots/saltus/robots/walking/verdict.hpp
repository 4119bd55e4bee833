// What a run came to: figures that any problem may judge by, and the verdict that it makes of them.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "saltus/robots/walking/body_verdict.hpp"
#include "saltus/robots/walking/push.hpp"
#include "saltus/robots/walking/run_log.hpp"

namespace saltus::walking {

/// Whether a run was a success, and figures of it.
struct Verdict {
  bool recovered = false;                                 ///< all criteria are met
  std::string reason;                                     ///< when not: the first one
  double final_com_error = 0.0, icp_settling = infinity;  ///< m, s
  double settled_from = 0.0;  ///< capture point and forces settle from then on: counted from it, s
  double com_height_min = infinity, com_height_max = -infinity;  ///< m
  double angular_momentum_max = 0.0;                             ///< Nms
  bool fell_before_push = false;    ///< whatever came of it says nothing about the push
  std::optional<BodyVerdict> body;  ///< of the whole body only

  /// Notes the first reason.
  void fail(std::string because) {
    if (reason.empty()) reason = std::move(because);
  }
};

// Bounds are often given for iCub, which has this mass and CoM height on one foot. For another
// robot lengths of the CoM scale with its height h, and angular momentum with m h sqrt(g h).
/// Of the robot that the criteria were made for; others are scaled: kg, m.
inline constexpr double reference_mass = 33.0616727, reference_height = 0.5578762015;  // kg, m
/// How near to its goal the capture point must stay to have settled, m.
inline constexpr double icp_settled_within = 0.01;  // m

/// Everything but `recovered`; the only reason is that the run was stopped early. The capture point
/// has settled when it stays where it is at the end, counted from `settled_from`, s.
Verdict figures_of(const RunLog& log, double settled_from, std::span<const Push> pushes);

/// Whether the robot lies on the ground, whatever follows; it stands on a foot at `foot` with its
/// CoM at `com_height`, m.
bool has_fallen(const Vec<double, 9>& gamma, const Vec<double, 3>& foot, double com_height);
/// The same as a sentence; a fall before all pushes is said as such.
std::string fall_sentence(std::span<const Push> pushes, double t);

}  // namespace saltus::walking
