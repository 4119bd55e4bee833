// Result of a solve of an optimal control problem.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "saltus/model/crossing.hpp"
#include "saltus/solver/optimum_check.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/trajectory.hpp"
#include "saltus/verify/verification.hpp"

namespace saltus {

/// Violation of a soft constraint. For a link or an integral, in the phase where it ends.
struct SoftViolation {
  std::string phase, term;  ///< names
  double largest = 0.0;     ///< violation in the term's own units
  double time = 0.0;        ///< s, at the largest violation
};

/// Zero crossing of the guard at the end of a phase.
struct GuardCrossing {
  std::string phase, event;  ///< names
  Crossing declared = {};    ///< the declared direction
  double time = 0.0;         ///< s, end of the phase
  /// g_t + g_x f at x-, in the guard's units per second. NaN in a phase with modes if the state
  /// does not determine the mode.
  double rate = 0.0;
  bool grazes = false;        ///< the rate is nearly zero: the event time is ill-defined
  double early_amount = 0.0;  ///< > 0: amount of an earlier crossing in the same direction
  double early_time = 0.0;    ///< s, time of the earlier crossing
  double largest = 0.0;       ///< magnitude of the guard along the phase

  /// True if the guard crosses zero in the declared direction only at the end.
  bool is_as_declared() const { return !grazes && !is_the_wrong_way() && early_amount == 0.0; }
  /// True if it crosses zero in the opposite direction.
  bool is_the_wrong_way() const { return !grazes && crossing_sign(declared) * rate < 0.0; }
};

/// Value of an integral (Phase::bound_integral) at the end of a phase.
struct IntegralValue {
  std::string phase, integral;  ///< names
  double value = 0.0;           ///< accumulated value
};

/// Name of the costs of Phase::penalise_change() in Solution::costs.
inline constexpr const char* change_of_inputs = "change of inputs";

/// Contribution of a named cost to the total.
struct CostContribution {
  std::string phase, term;  ///< names
  double value = 0.0;       ///< contribution to the cost
};

/// The solution of a problem.
struct Solution {
  Solution();
  Solution(const Solution& other);
  Solution(Solution&& other) noexcept;
  Solution& operator=(const Solution& other);
  Solution& operator=(Solution&& other) noexcept;
  ~Solution();

  SolveStatus status = SolveStatus::invalid_problem;  ///< outcome of the solve
  /// One sentence. For an infeasible constraint, it names phase, term, time and violation.
  std::string message;
  /// Possible mistakes in the definition, one sentence each (OptimalControlProblem::warnings). Also
  /// part of the message. Filled by solve(), not in control loops.
  std::vector<std::string> warnings;
  double cost = 0.0;                           ///< optimal cost if ok()
  Trajectory trajectory;                       ///< states and inputs over time
  std::vector<double> durations;               ///< of the phases, s
  std::vector<CostContribution> costs;         ///< contributions of the terms
  std::vector<SoftViolation> soft_violations;  ///< soft terms, largest violation first
  std::vector<IntegralValue> integrals;        ///< values of integral constraints
  /// One entry per phase that ends with a guard. The message reports crossings that differ from
  /// their declaration.
  std::vector<GuardCrossing> crossings;
  /// Result of the verifier: rows at and between the nodes, integration defects, open loop, cost.
  /// Filled by solve() unless GridAccuracy::verify is false. Empty in control loops.
  std::optional<Verification> verification;
  /// Second-order classification of the solution. solve() computes it if the Hessian is exact;
  /// control loops do not.
  OptimumCheck::Curvature curvature = OptimumCheck::Curvature::unknown;
  /// Possible decrease of the cost predicted by first and second derivatives, in units of the cost.
  /// NaN if solve() did not compute it.
  double predicted_gain = std::numeric_limits<double>::quiet_NaN();
  KktResidual kkt;  ///< computed from the program
  /// KKT residual in the scaling of the solve, to which the solver's tolerance refers. For a badly
  /// scaled program, in the scaling of the values at the solution
  /// (ShootingOptions::automatic_scale).
  KktResidual kkt_in_scale;
  int iterations = 0;    ///< solver iterations
  double seconds = 0.0;  ///< wall-clock time of the solver
  std::string method;    ///< integrator, cost rule, Hessian
  NlpPoint point;        ///< for warm starts
  /// d cost / d x0: multipliers of the start in physical units. Positive where a larger start value
  /// increases the cost. Equal to the costates up to sign conventions.
  VectorXd start_multipliers;

  /// True if it is optimal to the requested tolerance.
  bool ok() const { return is_success(status); }
};

}  // namespace saltus
