// A quadratic program with sparse data, and the interface of its solvers.
#pragma once

#include <memory>
#include <string>

#include "saltus/core/bounds.hpp"
#include "saltus/core/sparsity.hpp"
#include "saltus/core/types.hpp"
#include "saltus/qp/qp_result.hpp"

namespace saltus::qp {

/// min 1/2 w'Hw + gradient'w + constant subject to lower <= w <= upper and row_lower <= J w <=
/// row_upper. The patterns are fixed; all values may change between solves.
struct SparseQp {
  /// First-order optimality residuals: largest absolute entries, zero at the optimum.
  struct Residual {
    double stationarity = 0.0;     ///< gradient of the Lagrangian
    double feasibility = 0.0;      ///< rows and bounds
    double complementarity = 0.0;  ///< |multiplier| x distance to its side, and wrong signs
    /// The largest of the three.
    double largest() const;
  };

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

/// Computes the residual from the data of the program alone. Does not allocate.
SparseQp::Residual kkt_residual(const SparseQp& qp, const PrimalDualPoint& point);

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

// The interior-point method with a sparse factorisation: for programs without stages, and to
// cross-check the stage solver.

/// `hessian` is the lower triangle. Programs with other patterns and invalid data get the status
/// invalid_problem.
std::unique_ptr<QpSolver> make_sparse_qp_solver(const SparsityPattern& hessian,
                                                const SparsityPattern& rows,
                                                const QpOptions& options = {});

// Interface between methods that take one Newton step per point and the linear algebra of the
// program structure.

/// The equations of a barrier step, with H and J from the last load():
///
///     [ H + diag(variable weights)   J'                     ] [ dw      ]      [ rw ]
///     [ J                            -diag(1 / row weights) ] [ dlambda ] = -  [ rr ]
///
/// An infinite row weight makes the row an equality; a zero weight removes it. Fixed variables do
/// not move.
class NewtonSystem {
 public:
  virtual ~NewtonSystem() = default;
  /// Discards data of earlier runs, so that the same start always gives the same steps. Call it
  /// before the first factor() of a run.
  virtual void restart() {}
  /// Takes H and J. The bounds determine which variables are fixed, which rows are equalities and
  /// which sides exist; the gradient and the bound values are not read. Returns false if the
  /// structure cannot express the program or an entry is not finite.
  virtual bool load(const SparseQp& qp) = 0;
  /// Returns false if H + diag(variable weights) is not convex where the equalities hold (with the
  /// other rows as penalties), or if the factorisation broke down.
  virtual bool factor(const VectorXd& variable_weights, const VectorXd& row_weights) = 0;
  /// Solves for the step. The accuracy is limited; the caller refines the solution.
  virtual void solve(const VectorXd& rw, const VectorXd& rr, VectorXd& dw, VectorXd& dlambda) = 0;
  /// Factors again with another method if refinement does not converge. Returns false if no other
  /// method is left.
  virtual bool factor_with_fallback() { return false; }
};

}  // namespace saltus::qp

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
using SparseQp [[deprecated("use qp::SparseQp; removed in 0.4")]] = qp::SparseQp;
/// Deprecated name.
using QpSolver [[deprecated("use qp::QpSolver; removed in 0.4")]] = qp::QpSolver;
/// Deprecated name.
using SparseQpResidual [[deprecated("use qp::SparseQp::Residual; removed in 0.4")]] =
    qp::SparseQp::Residual;
using qp::make_sparse_qp_solver;  ///< deprecated name
}  // namespace saltus
