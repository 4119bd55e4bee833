// A quadratic program with an l1 penalty on its rows, so that it always has a feasible point.
//
//     min 1/2 w'Hw + g'w + weight sum(s + t)   subject to   lower <= w <= upper,
//     row_lower <= J w + s - t <= row_upper,  s, t >= 0
#pragma once

#include <memory>
#include <vector>

#include "saltus/core/clock.hpp"
#include "saltus/solver/native_solver.hpp"

namespace saltus {

class ElasticQp {
 public:
  /// For models of `program`. The relaxed programs have no stages.
  ElasticQp(const NonlinearProgram& program, const qp::SparseQp& shape, const QpMethod& method,
            const qp::QpOptions& options);

  /// `point` is the start and receives w and the multipliers.
  qp::QpResult solve(const qp::SparseQp& qp, double weight, PrimalDualPoint& point,
                     WallClock::time_point deadline);

 private:
  qp::SparseQp qp_;
  std::vector<int> position_;  // positions of the entries of J
  std::unique_ptr<qp::QpSolver> solver_;
  PrimalDualPoint point_;
};

}  // namespace saltus
