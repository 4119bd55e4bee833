// A sparse quadratic program that models KktSystem for the interior-point method.
#pragma once

#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/qp/lanes.hpp"
#include "saltus/qp/sparse_ldl.hpp"
#include "saltus/qp/sparse_qp.hpp"

namespace saltus::qp {

/// v is w without its fixed variables (equal bounds): they stay zero in v, and their values enter
/// the constants. The cost, y and lambda are divided by cost_unit(), the largest slope of the cost
/// at the origin (at least 1). Rounding and regularisation are relative to it. Rows with equal
/// sides are equalities; every other finite side of a row or bound is a side. Each load() may
/// change which rows are equalities.
///
/// solve() uses one matrix whose pattern covers all cases,
///
///     [ H + diag(bound weights) + rho     J'          ]
///     [ J                                 -1/w - delta ],   w: weights of a row's sides, infinite
///                                                         for an equality,
///
/// where rho, delta > 0 make the matrix quasi-definite. Refinement reduces the residual of the
/// equations without rho and delta as far as possible. If that is not enough, the matrix is
/// factored again with other values. Columns of fixed variables are zero except for a 1 on the
/// diagonal.
class SparseSystem {
 public:
  /// `hessian` is the lower triangle. Later programs must have these patterns.
  SparseSystem(const SparsityPattern& hessian, const SparsityPattern& rows);

  /// Loads the data. Returns false if they are invalid: NaN, crossed bounds, or sizes of other
  /// patterns.
  bool load(const SparseQp& qp);
  /// Converts between points and the arrays v, y and lambda of the loaded program.
  void load_point(const PrimalDualPoint& point, double* v, double* y, double* lambda) const;
  void unload_point(const SparseQp& qp, const double* v, const double* y, const double* lambda,
                    PrimalDualPoint& point) const;

  double cost_unit() const { return cost_unit_; }

  int max_variables() const { return padded(n_); }
  int max_equalities() const { return padded(m_); }
  int max_sides() const { return padded(2 * (n_ + m_)); }

  // Implements KktSystem.
  int variables() const { return padded(n_); }
  int equalities() const { return padded(static_cast<int>(equality_rows_.size())); }
  int sides() const { return padded(static_cast<int>(sides_.size())); }
  int first_soft() const { return sides(); }
  const double* active() const { return active_.data(); }
  const double* beta() const { return beta_.data(); }
  const double* l1() const { return weights_.data(); }
  const double* l2() const { return weights_.data(); }
  void evaluate(const double* v, const double* y, const double* lambda, double* stationarity,
                double* equality, double* side);
  void apply(const double* v, const double* y, const double* lambda, double* stationarity,
             double* equality, double* side);
  double cost(const double* v);
  void expect_convex(bool convex) { expects_convex_ = convex; }
  void set_shift(double shift) { shift_ = shift; }
  bool factor(const double* weights);
  void solve(const double* rv, const double* ry, double* dv, double* dy);
  /// For the last solution dv, rows with large weights are accurate to more digits than dv itself.
  void multiply(const double* v, double* side);
  void add_transposed(const double* side, double* v);
  void row_sizes(double* side);

  /// Number of factorisations since load() with another regularisation, because the first one broke
  /// down or gave poor solutions.
  int regularisation_changes() const { return changes_; }

 private:
  /// lower <= quantity has sign +1; quantity <= upper has sign -1.
  struct Side {
    int row;  ///< row index in J, or m + variable
    double sign;
  };
  void add_sides(int row, double lower, double upper, double offset);
  bool factor_with(double regularisation);
  /// Computes out = K x for the matrix without rho and delta. x and out hold variables, then rows.
  void multiply_matrix(const double* x, double* out) const;
  void multiply_rows(const double* v);
  void spread(const double* v, double* side) const;
  double backward_error() const;
  void refine(double& smallest);
  void next_level();
  void add_hessian_times(const double* v, double* out) const;

  SparsityPattern hessian_pattern_, row_pattern_;
  int n_ = 0, m_ = 0;
  VectorXd hessian_, rows_;  ///< values without the columns of fixed variables
  VectorXd gradient_;
  VectorXd fixed_;  ///< values of fixed variables, else zero
  std::vector<char> is_fixed_;
  VectorXd row_offset_;  ///< contribution of the fixed variables to each row

  std::vector<int> equality_rows_;
  VectorXd equality_;  ///< right-hand sides
  std::vector<Side> sides_;
  AlignedArray active_, beta_, weights_;

  SparseLdl ldl_;
  std::vector<int> hessian_slot_, row_slot_, diagonal_slot_;  ///< positions in the matrix pattern
  VectorXd hessian_diagonal_;
  VectorXd diagonal_;  ///< diagonal without H, rho and delta: bound weights, -1/w
  VectorXd right_side_, solution_, residual_, best_;
  bool best_is_of_factor_ = false;  ///< true if best_ solves the current factor and rows
  VectorXd row_work_;
  double cost_unit_ = 1.0;
  bool expects_convex_ = true;
  double shift_ = 0.0;
  double scale_ = 1.0;      ///< largest entry of H, at least 1: the unit of rho
  double row_scale_ = 0.0;  ///< largest entry of J
  std::size_t level_ = 0;   ///< current index of the regularisation
  int changes_ = 0;
};

}  // namespace saltus::qp
