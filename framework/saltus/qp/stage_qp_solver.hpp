// The seam between quadratic programs in stages and their solvers.
#pragma once

#include "saltus/qp/qp_result.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus {

/// A solver for programs within the capacity of the one it was made for. After construction
/// nothing allocates.
class StageQpSolver {
 public:
  virtual ~StageQpSolver() = default;
  /// `point` holds the start (with `warm` its multipliers count too) and receives the solution.
  virtual QpResult solve(const StageQp& qp, StagePoint& point, bool warm) noexcept = 0;
  /// Later solves stop at this instant; time_point::max(): never.
  virtual void set_deadline(WallClock::time_point deadline) = 0;
};

}  // namespace saltus
