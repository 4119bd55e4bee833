// Interface of solvers of quadratic programs in stages.
#pragma once

#include "saltus/qp/qp_result.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus {

/// A solver for programs within the capacity of the one it was made for. It does not allocate after
/// construction.
class StageQpSolver {
 public:
  virtual ~StageQpSolver() = default;
  /// `point` is the start and receives the solution. With `warm`, its multipliers are used too.
  virtual QpResult solve(const StageQp& qp, StagePoint& point, bool warm) noexcept = 0;
  /// Later solves stop at this time; time_point::max(): no deadline.
  virtual void set_deadline(WallClock::time_point deadline) = 0;
};

}  // namespace saltus
