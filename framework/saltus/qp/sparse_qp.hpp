// A quadratic program with sparse data, and the seam between it and its solvers.
#pragma once

#include <memory>
#include <string>

#include "saltus/core/bounds.hpp"
#include "saltus/core/primal_dual_point.hpp"
#include "saltus/core/sparsity.hpp"
#include "saltus/core/types.hpp"
#include "saltus/qp/qp_result.hpp"

namespace saltus {

/// min 1/2 w'Hw + gradient'w + constant subject to lower <= w <= upper and
/// row_lower <= J w <= row_upper. Patterns are fixed; everything else may change between solves.
struct SparseQp {
  SparsityPattern hessian_pattern;              ///< lower triangle
  SparsityPattern row_pattern;                  ///< rows x variables
  VectorXd hessian, rows;                       ///< values in the order of their patterns
  VectorXd gradient;                            ///< linear part of the cost
  double constant = 0.0;                        ///< part of the cost that no variable changes
  VectorXd lower, upper, row_lower, row_upper;  ///< may be infinite; equal sides are equalities

  SparseQp() = default;
  /// Zeros, without bounds.
  SparseQp(SparsityPattern hessian_pattern, SparsityPattern row_pattern);
  /// How many.
  int variables() const { return static_cast<int>(gradient.size()); }
};

/// Cost of w.
double objective(const SparseQp& qp, const VectorXd& w);

/// First-order optimality, each the largest absolute entry; zero at the optimum.
struct SparseQpResidual {
  double stationarity = 0.0;     ///< of the Lagrangian
  double feasibility = 0.0;      ///< rows and bounds
  double complementarity = 0.0;  ///< |multiplier| x distance to its side, and wrong signs
  /// The largest of the three.
  double largest() const;
};
/// From the data of the program and nothing else. Does not allocate.
SparseQpResidual kkt_residual(const SparseQp& qp, const PrimalDualPoint& point);

/// A solver for programs with the patterns it was made for. After construction nothing allocates.
class QpSolver {
 public:
  virtual ~QpSolver() = default;
  /// `point` holds the start (with `warm` its multipliers count too) and receives the solution.
  virtual QpResult solve(const SparseQp& qp, PrimalDualPoint& point, bool warm) noexcept = 0;
  /// Later solves stop at this instant; time_point::max(): never.
  virtual void set_deadline(WallClock::time_point deadline) = 0;
  /// For messages and results.
  virtual std::string name() const = 0;
};

}  // namespace saltus
