// The step recovery of a humanoid as a quadratic program in stages: the instance on which solvers
// are compared. All numbers of the recipe are here; they are not those of the push_recovery problem.
#pragma once

#include <cstdint>

#include "framework/qp/stage_qp.hpp"

namespace saltus::bench {

/// CoM position and velocity (m, m/s) and angular momentum (Nms).
using CentroidalState = Vec<double, 9>;

struct StepRecovery {
  int intervals = 15;
  int landing = 7;  ///< first stage with both feet; >= intervals: the landing is beyond the horizon
};

CentroidalState nominal_start();
/// Pushed towards -y by 0.2 to 0.3 m/s within 0.4 rad, position within (10, 5, 5) mm of the nominal
/// one, angular momentum within (0.4, 0.4, 0.1) Nms.
CentroidalState random_start(std::uint64_t seed);

/// Inputs are wrenches divided by 100 N and 10 Nm: stance foot, then the other one.
StageQp step_recovery_qp(const StepRecovery& options, const CentroidalState& start);

/// A point with the weight on the feet that stand and zero states.
StagePoint standing_guess(const StageQp& qp);

}  // namespace saltus::bench
