// Sensitivity of an optimum to changes of the program: its KKT system and the conditions for it.
//
// The active rows and bounds (equalities, and sides with a multiplier) are treated as equations.
// Let A be the Jacobian of these rows, H the Hessian of the Lagrangian, F the variables without an
// active bound and B the others. If the program depends on a parameter theta, its optimum moves by
//
//     [ H_FF  A_F' ] [ dw_F    ]     [ d_theta grad_F L + H_FB dw_B    ]
//     [ A_F   0    ] [ dlambda ] = - [ d_theta (g - side)  + A_B dw_B ],    dw_B = d_theta side,
//
// This holds if the gradients of active constraints are independent (LICQ), each active inequality
// has a multiplier (strict complementarity), and H is positive definite on their tangent space
// (second order). A. V. Fiacco, Introduction to Sensitivity and Stability Analysis in Nonlinear
// Programming, 1983, theorem 3.2.2. All three conditions are checked.
//
// The same system refines the optimum by Newton steps. Multipliers are then as accurate as the
// functions, independent of the solver tolerance.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Rates of change of the optimality conditions at fixed w and multipliers.
struct OptimumRates {
  VectorXd gradient;  ///< rate of the gradient of the Lagrangian, per variable
  VectorXd rows;      ///< rate of g - side per row; for inactive rows, of g
  VectorXd bounds;    ///< rate of the side of an active bound, per variable
};

/// Derivative of the optimum.
struct OptimumMovement {
  VectorXd w, lambda;  ///< derivatives of the variables and of the multipliers of rows
  /// If not empty, a sentence: an active side without a multiplier would become inactive or active,
  /// and the derivative holds in one direction only.
  std::string one_sided;
};

/// Allocates; for analysis, not for control loops. The program must outlive this object and be in
/// the state of the optimum at construction.
class OptimumSystem {
 public:
  /// `curvature`: lower triangle of all possible second derivatives. Those in the program's own
  /// pattern are evaluated, others are found by differences.
  OptimumSystem(NonlinearProgram& program, const NlpPoint& optimum, SparsityPattern curvature);
  ~OptimumSystem();
  OptimumSystem(OptimumSystem&&) noexcept;
  OptimumSystem& operator=(OptimumSystem&&) noexcept;

  /// True if LICQ and the second-order condition hold. Otherwise message() names the violated
  /// condition and its place in one sentence. Strict complementarity is checked for each movement.
  bool reliable() const { return message_.empty(); }
  /// Reason why there are no sensitivities; empty if there are.
  const std::string& message() const { return message_; }
  /// True if the system was factored, reliable or not.
  bool is_factored() const { return factors_ != nullptr; }
  /// "exact", or "differences of gradients" if the program has no second derivatives.
  const std::string& hessian() const { return hessian_name_; }
  /// The refined optimum. Multipliers of inactive constraints are zero. Those of variables with
  /// equal bounds balance the gradient.
  const NlpPoint& point() const { return point_; }
  /// Scaled KKT error of point().
  double residual() const { return residual_; }
  /// Active side of the row: 1 upper (or an equality), -1 lower, 0 none.
  int row_side(int row) const { return row_sides_[row]; }
  /// Active bound of the variable: 1 upper, -1 lower, 0 none.
  int bound_side(int variable) const { return bound_sides_[variable]; }

  OptimumRates no_rates() const;  ///< zeros
  /// Returns false if the system has no solution.
  bool solve(const OptimumRates& rates, OptimumMovement& moved) const;
  /// Computes the movement if a variable is fixed at w + 1 instead of its value. Returns false if
  /// active rows do not permit it.
  bool hold(int variable, OptimumMovement& moved) const;

 private:
  struct Factors;
  struct State {  // a point to return to
    NlpPoint point;
    std::vector<int> row_sides, bound_sides;
  };

  void classify();
  bool change_sides();
  bool evaluate();
  double defect() const;
  bool factor();
  bool newton_step();
  std::string one_sided(const OptimumRates& rates, const OptimumMovement& moved) const;
  void check();
  bool has_positive_curvature() const;
  double row_gap(int row) const;
  double bound_gap(int variable) const;

  NonlinearProgram* program_;
  NlpPoint point_;
  SparsityPattern pattern_;  // pattern of curvature_
  std::vector<int> row_sides_, bound_sides_;
  std::string message_, hessian_name_;
  double residual_ = 0.0;
  // rows and bounds with neither distance nor multiplier
  std::vector<int> weak_rows_, weak_bounds_;

  // Values at point_.
  VectorXd gradient_, g_, stationarity_;  // stationarity: grad f + J' lambda, without bounds
  std::vector<double> jacobian_, curvature_;

  std::vector<int> unknown_of_;  // position of a variable among the unknowns; -1: at a bound
  std::vector<int> row_of_;      // rows of the unknown multipliers
  std::vector<int> unknown_of_row_;
  int free_ = 0;
  std::unique_ptr<Factors> factors_;
};

}  // namespace saltus
