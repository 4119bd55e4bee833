// Verdict on a run, and the quantities from which problems derive it.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "saltus/robots/walking/body_verdict.hpp"
#include "saltus/robots/walking/push.hpp"
#include "saltus/robots/walking/run_log.hpp"

namespace saltus::walking {

/// Success of a run, with its quantities.
struct Verdict {
  bool recovered = false;                                 ///< all criteria are met
  std::string reason;                                     ///< if not recovered: the first reason
  double final_com_error = 0.0, icp_settling = infinity;  ///< m, s
  double settled_from = 0.0;  ///< time from which settling is measured, s
  double com_height_min = infinity, com_height_max = -infinity;  ///< m
  double angular_momentum_max = 0.0;                             ///< Nms
  bool fell_before_push = false;    ///< true if the run says nothing about the push
  std::optional<BodyVerdict> body;  ///< whole body only

  /// Notes the first reason.
  void fail(std::string because) {
    if (reason.empty()) reason = std::move(because);
  }
};

// Bounds are often given for iCub, with this mass and CoM height on one foot. For other robots,
// lengths of the CoM scale with its height h, and angular momentum with m h sqrt(g h).
/// Mass (kg) and CoM height (m) of the robot for which the criteria were chosen. Criteria of other
/// robots are scaled.
inline constexpr double reference_mass = 33.0616727, reference_height = 0.5578762015;  // kg, m
/// Distance within which the capture point counts as settled, m.
inline constexpr double icp_settled_within = 0.01;  // m

/// All quantities except `recovered`. The only reason it can give is an early stop. The capture
/// point has settled when it stays near its final position; the time is measured from
/// `settled_from`, s.
Verdict figures_of(const RunLog& log, double settled_from, std::span<const Push> pushes);

/// True if the robot has fallen. It stands on a foot at `foot` with its CoM at the nominal height
/// `com_height`, m.
bool has_fallen(const Vec<double, 9>& gamma, const Vec<double, 3>& foot, double com_height);
/// Sentence for a fall; mentions a fall before all pushes.
std::string fall_sentence(std::span<const Push> pushes, double t);

}  // namespace saltus::walking
