// Result of a solve of an optimal control problem.
#pragma once

#include <iosfwd>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "saltus/model/integrator.hpp"
#include "saltus/model/switching_system.hpp"
#include "saltus/solver/optimum_check.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/verify/verification.hpp"

namespace saltus {

// The trajectory of a solution: states and inputs at any time with the accuracy of the integrator,
// and CSV output.

/// States, inputs and parameters of a plan over time, in pieces. Right-continuous: at an event,
/// values are those of the new phase, x+ after the jump.
///
/// Value semantics: several threads may read a trajectory or its copies concurrently, also while
/// the program or controller that made it continues. Reading allocates and is not for control
/// loops. Members throw DefinitionError if the trajectory is empty or a given time is NaN. The plan
/// of a failed solve may contain NaN times; values read from it are NaN.
class Trajectory {
 public:
  /// One shooting interval of a solution.
  struct Piece {
    int phase = 0;          ///< index of the phase
    double start = 0.0;     ///< absolute time, s
    double length = 0.0;    ///< s, positive
    VectorXd state;         ///< state at the start of the interval
    VectorXd coefficients;  ///< input coefficients, see InputShape
    VectorXd end_state;     ///< state of the node at its end, before any jump

    /// End time, s.
    double end() const { return start + length; }
  };

  /// Data of a phase.
  struct PhaseInfo {
    std::string name;     ///< also the name of the mode
    VectorXd parameters;  ///< p of the phase: data and unknowns
    /// Problem and scheme of the solve.
    std::shared_ptr<const ReentrantIntegrator> integrator;
  };

  Trajectory();
  Trajectory(const Trajectory& other);
  Trajectory(Trajectory&& other) noexcept;
  Trajectory& operator=(const Trajectory& other);
  Trajectory& operator=(Trajectory&& other) noexcept;
  ~Trajectory();
  /// Pieces in order of time. Throws DefinitionError if a phase has no integrator, a piece refers
  /// to no phase, or a size differs from that of its phase.
  Trajectory(std::vector<PhaseInfo> phases, std::vector<Piece> pieces);

  /// True if it has no pieces.
  bool empty() const { return pieces_.empty(); }
  /// The phases in order.
  const std::vector<PhaseInfo>& phases() const { return phases_; }
  /// One piece per interval in order of time.
  const std::vector<Piece>& pieces() const { return pieces_; }
  /// Start of the first piece, s.
  double start_time() const;
  /// End of the last piece, s.
  double end_time() const;
  /// State at the end of the last phase.
  const VectorXd& final_state() const;

  /// The piece at time t. Times outside the trajectory are clipped.
  const Piece& piece_at(double t) const;
  /// State at time t, integrated from the node before t (dense output).
  VectorXd state(double t) const;
  /// Left limit: x- of the old phase at an event, elsewhere state(t).
  VectorXd state_before(double t) const;
  /// Input at time t, right-continuous at control breaks.
  VectorXd input(double t) const;
  /// State at time t within one of pieces(), without the lookup by time and its rounding at the
  /// ends.
  VectorXd state_in(const Piece& piece, double t) const;
  /// Input at time t within a piece. At its end this is the left limit.
  VectorXd input_in(const Piece& piece, double t) const;
  /// Algebraic states at time t. Empty if the phase has none, NaN if they cannot be found.
  VectorXd algebraic(double t) const;

  /// The trajectory without its first `phases` phases. Throws DefinitionError if none remains.
  Trajectory after(int phases) const;

  /// Writes a header and one line per sample: t, phase, x0..., u0..., z0... Columns that a phase
  /// does not have are empty. Events appear twice, with the values before and after.
  void write_csv(std::ostream& out, int samples_per_interval = 1) const;

 private:
  const PhaseInfo& phase_of(const Piece& piece) const;
  VectorXd algebraic_in(const Piece& piece, double t) const;

  std::vector<PhaseInfo> phases_;
  std::vector<Piece> pieces_;
};
/// Deprecated name.
using TrajectoryPiece [[deprecated("use Trajectory::Piece; removed in 0.4")]] = Trajectory::Piece;

/// Name of the costs of Phase::penalise_change() in Solution::costs.
inline constexpr const char* change_of_inputs = "change of inputs";

/// The solution of a problem.
struct Solution {
  /// Multipliers of one row of a constraint at its grid points, in the units of the problem.
  struct Multiplier {
    static constexpr const char* costate = "costate";  ///< `term` of the costates

    std::string phase;  ///< name of the phase; empty: the whole problem
    /// Name of the term, link or integral, "total time", "bounds of state 0", "bounds of input 0",
    /// or "costate".
    std::string term;
    int row = 0;                ///< row of the term, or index of the state
    std::vector<double> times;  ///< times of the grid points, s
    /// Derivatives of the optimal cost with respect to the active bound, positive at a lower and
    /// negative at an upper bound. For costates, with respect to the state.
    std::vector<double> values;
  };

  /// Violation of a soft constraint. `phase` of a link or an integral is the phase where it ends.
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
    bool is_as_declared() const { return !grazes && !has_wrong_direction() && early_amount == 0.0; }
    /// True if it crosses zero in the opposite direction.
    bool has_wrong_direction() const { return !grazes && crossing_sign(declared) * rate < 0.0; }
    /// Deprecated name.
    [[deprecated("use has_wrong_direction; removed in 0.4")]] bool is_the_wrong_way() const {
      return has_wrong_direction();
    }
  };

  /// Value of an integral (Phase::bound_integral) at the end of a phase.
  struct IntegralValue {
    std::string phase, integral;  ///< names
    double value = 0.0;           ///< accumulated value
  };

  /// Contribution of a named cost to the total.
  struct CostContribution {
    std::string phase, term;  ///< names
    double value = 0.0;       ///< contribution to the cost
  };

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
  std::vector<double> durations;               ///< duration of each phase, s
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
  KktCheck::Residual kkt;  ///< computed from the program
  /// KKT residual in the scaling of the solve, to which the solver's tolerance refers. For a badly
  /// scaled program, in the scaling of the values at the solution
  /// (ShootingOptions::automatic_scale).
  KktCheck::Residual kkt_in_scale;
  int iterations = 0;    ///< solver iterations
  double seconds = 0.0;  ///< wall-clock time of the solver
  std::string method;    ///< integrator, cost rule, Hessian
  NlpPoint point;        ///< primal-dual point for warm starts
  /// Multipliers of all constraints. solve() fills them, but control loops do not.
  std::vector<Multiplier> multipliers;
  /// d cost / d x0: multipliers of the start in physical units. Positive where a larger start value
  /// increases the cost. Equal to the costates up to sign conventions.
  VectorXd start_multipliers;

  /// True if it is optimal to the requested tolerance.
  bool ok() const { return is_success(status); }
};
/// Deprecated name.
using SoftViolation [[deprecated("use Solution::SoftViolation; removed in 0.4")]] =
    Solution::SoftViolation;
/// Deprecated name.
using GuardCrossing [[deprecated("use Solution::GuardCrossing; removed in 0.4")]] =
    Solution::GuardCrossing;
/// Deprecated name.
using CostContribution [[deprecated("use Solution::CostContribution; removed in 0.4")]] =
    Solution::CostContribution;

}  // namespace saltus
