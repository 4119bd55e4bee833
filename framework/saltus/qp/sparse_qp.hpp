// A quadratic program with sparse data, and the interface of its solvers.
#pragma once

#include <memory>
#include <string>

#include "saltus/core/bounds.hpp"
#include "saltus/core/primal_dual_point.hpp"
#include "saltus/core/sparsity.hpp"
#include "saltus/core/types.hpp"
#include "saltus/qp/qp_result.hpp"

namespace saltus {

/// min 1/2 w'Hw + gradient'w + constant subject to lower <= w <= upper and row_lower <= J w <=
/// row_upper. The patterns are fixed; all values may change between solves.
struct SparseQp {
  SparsityPattern hessian_pattern;              ///< lower triangle
  SparsityPattern row_pattern;                  ///< rows x variables
  VectorXd hessian, rows;                       ///< values in the order of their patterns
  VectorXd gradient;                            ///< linear part of the cost
  double constant = 0.0;                        ///< constant part of the cost
  VectorXd lower, upper, row_lower, row_upper;  ///< may be infinite; equal sides are equalities

  SparseQp() = default;
  /// Zero data without bounds.
  SparseQp(SparsityPattern hessian_pattern, SparsityPattern row_pattern);
  /// Number of variables.
  int variables() const { return static_cast<int>(gradient.size()); }
};

/// Cost at w.
double objective(const SparseQp& qp, const VectorXd& w);

/// First-order optimality residuals: largest absolute entries, zero at the optimum.
struct SparseQpResidual {
  double stationarity = 0.0;     ///< gradient of the Lagrangian
  double feasibility = 0.0;      ///< rows and bounds
  double complementarity = 0.0;  ///< |multiplier| x distance to its side, and wrong signs
  /// The largest of the three.
  double largest() const;
};
/// Computes the residual from the data of the program alone. Does not allocate.
SparseQpResidual kkt_residual(const SparseQp& qp, const PrimalDualPoint& point);

/// A solver for programs with the patterns it was made for. It does not allocate after
/// construction.
class QpSolver {
 public:
  virtual ~QpSolver() = default;
  /// `point` is the start and receives the solution. With `warm`, its multipliers are used too.
  virtual QpResult solve(const SparseQp& qp, PrimalDualPoint& point, bool warm) noexcept = 0;
  /// Later solves stop at this time; time_point::max(): no deadline.
  virtual void set_deadline(WallClock::time_point deadline) = 0;
  /// Name of the solver in messages and results.
  virtual std::string name() const = 0;
};

}  // namespace saltus
