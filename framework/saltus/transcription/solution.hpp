// What a solve of an optimal control problem returns.
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

/// How much of a soft constraint was given up; of a link or an integral in the phase where it ends.
struct SoftViolation {
  std::string phase, term;  ///< where and what
  double largest = 0.0;     ///< violation in the term's own units
  double time = 0.0;        ///< s, where it is largest
};

/// How the guard that ends a phase passed zero there.
struct GuardCrossing {
  std::string phase, event;  ///< where and what
  Crossing declared = {};    ///< the direction asked for
  double time = 0.0;         ///< s, end of the phase
  /// g_t + g_x f at x-, in the guard's units per second; NaN: of a phase with modes where the state
  /// does not tell which one is in force.
  double rate = 0.0;
  bool grazes = false;        ///< the rate is as good as zero: the time is not well defined
  double early_amount = 0.0;  ///< above zero: it had passed zero that way before, by so much
  double early_time = 0.0;    ///< s, where that was
  double largest = 0.0;       ///< magnitude of the guard along the phase

  /// Whether the guard passes zero in the declared direction.
  bool is_as_declared() const { return !grazes && !is_the_wrong_way() && early_amount == 0.0; }
  /// Whether it passes zero in the other one.
  bool is_the_wrong_way() const { return !grazes && crossing_sign(declared) * rate < 0.0; }
};

/// What an integral of a phase (Phase::bound_integral) has come to at its end.
struct IntegralValue {
  std::string phase, integral;  ///< where and what
  double value = 0.0;           ///< what it adds up to
};

/// Name of the costs of Phase::penalise_change() in Solution::costs.
inline constexpr const char* change_of_inputs = "change of inputs";

/// What a named cost adds to the total.
struct CostContribution {
  std::string phase, term;  ///< where and what
  double value = 0.0;       ///< its part of the cost
};

/// What a solve of a problem gave.
struct Solution {
  Solution();
  Solution(const Solution& other);
  Solution(Solution&& other) noexcept;
  Solution& operator=(const Solution& other);
  Solution& operator=(Solution&& other) noexcept;
  ~Solution();

  SolveStatus status = SolveStatus::invalid_problem;  ///< how it ended
  /// A sentence; when a constraint cannot be met it names phase, term and time, and by how much.
  std::string message;
  /// What looks like a mistake in the definition, a sentence each
  /// (OptimalControlProblem::warnings); said in the message too. Asked by solve(), not in control
  /// loops.
  std::vector<std::string> warnings;
  double cost = 0.0;                           ///< the optimal one, if it ended well
  Trajectory trajectory;                       ///< states and inputs over time
  std::vector<double> durations;               ///< of the phases, s
  std::vector<CostContribution> costs;         ///< what each term adds
  std::vector<SoftViolation> soft_violations;  ///< of soft terms, the largest first
  std::vector<IntegralValue> integrals;        ///< of integral constraints
  /// Of every phase that ends by a guard. What is not as declared is said in the message too.
  std::vector<GuardCrossing> crossings;
  /// What the verifier found: rows between and at the nodes, defects of the integration, the open
  /// loop, the cost. Filled by solve() unless GridAccuracy::verify is false; empty in control
  /// loops.
  std::optional<Verification> verification;
  /// What second derivatives say of the solution: looked at by solve() where the Hessian is exact,
  /// not in control loops.
  OptimumCheck::Curvature curvature = OptimumCheck::Curvature::unknown;
  /// By how much the cost could still fall, as first and second derivatives predict it, in its own
  /// units. NaN where solve() did not look.
  double predicted_gain = std::numeric_limits<double>::quiet_NaN();
  KktResidual kkt;  ///< recomputed from the program
  /// The same in the scale in which it was solved, which is what the solver's tolerance is about,
  /// or in that of the values at the solution where they are unusual
  /// (ShootingOptions::automatic_scale).
  KktResidual kkt_in_scale;
  int iterations = 0;    ///< of the solver
  double seconds = 0.0;  ///< wall clock of the solver
  std::string method;    ///< integrator, cost rule, Hessian
  NlpPoint point;        ///< for warm starts
  /// d cost / d x0: the multipliers of the start, in physical units (costates up to sign
  /// conventions: positive where a larger start value costs more).
  VectorXd start_multipliers;

  /// Whether it is an optimum as good as asked for.
  bool ok() const { return is_success(status); }
};

}  // namespace saltus
