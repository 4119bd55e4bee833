// The step recovery of a humanoid as a quadratic program in stages, for the comparison of solvers.
// This file has all numbers of the recipe; they differ from those of the push_recovery problem.
#pragma once

#include <array>
#include <cstdint>

#include "saltus/core/bounds.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

/// CoM position and velocity (m, m/s) and angular momentum (Nms).
using CentroidalState = Vec<double, 9>;

struct StepRecovery {
  int intervals = 15;
  int landing = 7;  ///< first stage with both feet; > intervals: the landing is beyond the horizon

  static constexpr double mass = 33.0, tick = 0.01;                  // kg, s
  static constexpr double force_unit = 100.0, torque_unit = 10.0;    // units of the inputs; N, Nm
  static constexpr std::array<double, 3> left_foot{0.0, 0.07, 0.0};  // m
  static constexpr std::array<double, 3> right_foot{0.05, -0.15, 0.0};
};

CentroidalState nominal_start();
/// Pushed towards -y within 0.4 rad by a speed in m/s, by default that of the recipe. The position
/// is within (10, 5, 5) mm of the nominal one, the angular momentum within (0.4, 0.4, 0.1) Nms.
CentroidalState random_start(std::uint64_t seed, const Bounds& push = between(0.2, 0.3));
/// Pushes for which the capture point reaches the edge of the hull after the landing at stage 7 of
/// 15. All have a solution, and in 994 of the first 1000 seeds a row is active.
inline constexpr Bounds binding_push{0.9, 1.0};

/// Inputs are wrenches divided by 100 N and 10 Nm: stance foot, then the other one.
qp::StageQp step_recovery_qp(const StepRecovery& options, const CentroidalState& start);

/// A point with the weight on the stance feet and zero states.
qp::StagePoint standing_guess(const qp::StageQp& qp);

}  // namespace saltus::bench
