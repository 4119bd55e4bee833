// How does an optimum move when the program changes? Its KKT system, and whether it can tell.
//
// Rows and bounds that hold the optimum (equalities, and sides with a multiplier) are taken as
// equations. With A the Jacobian of those rows, H the Hessian of the Lagrangian, F the variables
// that no bound holds and B the others, the optimum of a program that depends on a parameter theta
// moves by
//
//     [ H_FF  A_F' ] [ dw_F    ]     [ d_theta grad_F L + H_FB dw_B    ]
//     [ A_F   0    ] [ dlambda ] = - [ d_theta (g - side)  + A_B dw_B ],    dw_B = d_theta side,
//
// provided that the gradients of what holds are independent (LICQ), that each inequality among them
// has a multiplier (strict complementarity) and that H is positive definite on their surface
// (second order). A. V. Fiacco, Introduction to Sensitivity and Stability Analysis in Nonlinear
// Programming, 1983, theorem 3.2.2. All three are checked.
//
// The same system refines the optimum by Newton steps, so that multipliers are as exact as the
// functions and not as the tolerance of the solver.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// How fast, at fixed w and multipliers, the conditions of an optimum change.
struct OptimumRates {
  VectorXd gradient;  ///< of the gradient of the Lagrangian, per variable
  VectorXd rows;      ///< of g - side, per row; of a row that does not hold: of g
  VectorXd bounds;    ///< of the side of a bound that holds, per variable
};

/// How the optimum follows.
struct OptimumMovement {
  VectorXd w, lambda;  ///< of variables and of multipliers of rows
  /// Not empty: a sentence. A side that is met without a multiplier would begin to hold, or cease
  /// to, and the movement is that of one direction only.
  std::string one_sided;
};

/// Allocates; meant for analysis, not for control loops. The program must outlive it, and be the
/// one of the optimum when it is constructed.
class OptimumSystem {
 public:
  /// `curvature`: lower triangle of the second derivatives that there may be. The program's own
  /// pattern has those that it delivers; others are found by differences.
  OptimumSystem(NonlinearProgram& program, const NlpPoint& optimum, SparsityPattern curvature);
  ~OptimumSystem();
  OptimumSystem(OptimumSystem&&) noexcept;
  OptimumSystem& operator=(OptimumSystem&&) noexcept;

  /// LICQ and second order hold; otherwise message() says in a sentence which does not, and where.
  /// Strict complementarity matters, and is judged, for each movement.
  bool reliable() const { return message_.empty(); }
  /// Why there are none; empty if there are.
  const std::string& message() const { return message_; }
  /// Whether there is a system at all, reliable or not.
  bool is_factored() const { return factors_ != nullptr; }
  /// "exact", or "differences of gradients" where the program has no second derivatives.
  const std::string& hessian() const { return hessian_name_; }
  /// Refined; multipliers of what does not hold are zero, those of variables with equal bounds are
  /// what balances the gradient.
  const NlpPoint& point() const { return point_; }
  /// Scaled KKT error of point().
  double residual() const { return residual_; }
  /// Which side holds: 1 upper (or an equality), -1 lower, 0 none.
  int row_side(int row) const { return row_sides_[row]; }
  /// Which bound holds a variable: -1 lower, 1 upper, 0 none.
  int bound_side(int variable) const { return bound_sides_[variable]; }

  OptimumRates no_rates() const;  ///< zeros
  /// False where the system has no solution.
  bool solve(const OptimumRates& rates, OptimumMovement& moved) const;
  /// Movement when a variable is held at w + 1 in place of where it is. False where rows that hold
  /// do not let it go.
  bool hold(int variable, OptimumMovement& moved) const;

 private:
  struct Factors;
  struct State {  // of a point, for taking a step back
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
  bool curved_upward() const;
  double row_gap(int row) const;
  double bound_gap(int variable) const;

  NonlinearProgram* program_;
  NlpPoint point_;
  SparsityPattern pattern_;  // of curvature_
  std::vector<int> row_sides_, bound_sides_;
  std::string message_, hessian_name_;
  double residual_ = 0.0;
  std::vector<int> weak_rows_, weak_bounds_;  // neither distance nor multiplier

  // At point_.
  VectorXd gradient_, g_, stationarity_;  // stationarity: grad f + J' lambda, without bounds
  std::vector<double> jacobian_, curvature_;

  std::vector<int> unknown_of_;  // of a variable among the unknowns, -1: held by a bound
  std::vector<int> row_of_;      // of the unknown multipliers
  std::vector<int> unknown_of_row_;
  int free_ = 0;
  std::unique_ptr<Factors> factors_;
};

}  // namespace saltus
