// Explains why a problem is infeasible, by how much, and which changes would help. Also explains
// why a soft term is violated at the optimum.
//
//     const Solution plan = solve(problem);
//     if (plan.status == SolveStatus::infeasible) std::cout << explain(problem).text();
//
// explain() computes the least relaxation (solver/elastic_program.hpp) of the negotiable
// constraints: hard terms, bounds of states, links, integrals, the closing and the total time, each
// divided by its nominal value. Dynamics, jumps, the start, inputs and durations are not relaxed.
// Multipliers of the relaxed optimum show how they could help. Each remedy is verified by a solve
// before it is reported.
//
// If all of these are feasible, the problem is solved and each violated soft term is examined:
// could it hold as a hard term? If not, explain() reports the least shortage and what would help.
// If so, it reports the cost of holding it, the cost term that outweighs it, and the weight that
// makes it hold.
//
// A controller tick can be explained afterwards: explain(current_problem(controller.shooting())).
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {

// Change of one number of a problem: a bound, a time, a value.

/// One number of a definition and its change.
struct ProblemChange {
  /// Kind of the number.
  enum class Kind {
    term,        ///< bounds of a hard constraint
    state,       ///< bounds of a state
    input,       ///< bounds of an input
    integral,    ///< limits of an integral
    link,        ///< limits of a link
    duration,    ///< duration of a phase in seconds: fixed, or a bound of a free one
    total_time,  ///< bounds of the total time in seconds
    event,       ///< time of an event in the schedule, in seconds
    parameter,   ///< data, or a bound of an unknown
    start        ///< initial state, or a bound of a free one
  };
  /// Side that moves; equal sides move together.
  enum class Side { lower, upper };

  Kind kind = Kind::term;   ///< kind of the number
  int phase = 0;            ///< not read for links, events and the total time
  std::string name = {};    ///< name of the term, integral, link, event or parameter
  int component = 0;        ///< row of a term or link; entry of a parameter, state or input
  Side side = Side::upper;  ///< side of bounds
  double by = 0.0;          ///< added amount, in the units of the number
};

/// Name of the kind: "term", "duration".
const char* describe(ProblemChange::Kind kind);
/// Returns the changed problem. Throws DefinitionError if the number does not exist.
OptimalControlProblem changed(const OptimalControlProblem& problem, const ProblemChange& change);
/// The number before the change. Throws DefinitionError if it does not exist.
double value_before(const OptimalControlProblem& problem, const ProblemChange& change);
/// "with the upper bound of input 0 in phase 'ride' at 4.2 in place of 3"
std::string describe(const OptimalControlProblem& problem, const ProblemChange& change);

// Result of explain() as text and data: shortages, violated soft terms and remedies.

/// Result of explain().
struct Explanation {
  /// Shortage of one side of a term over all its nodes: the amount by which its bound would have to
  /// move.
  struct Shortage {
    /// "term", "state", "integral", "link", "closing" or "total time".
    std::string kind = {};
    std::string phase = {};  ///< empty if it belongs to no phase
    std::string term = {};   ///< name; for the bounds of a state "state 1"
    int component = 0;       ///< row of the term
    ProblemChange::Side side = ProblemChange::Side::upper;  ///< violated side
    double amount = 0.0;    ///< shortage in the term's own units, positive
    double nominal = 1.0;   ///< nominal value of the term
    double time = 0.0;      ///< time in seconds of the largest multiplier
    double value = 0.0;     ///< value at that time
    double bound = 0.0;     ///< violated bound at that time
    bool is_exact = false;  ///< lower and upper bound are equal
    /// True if the program is linear-quadratic and proved to be infeasible. Otherwise the shortage
    /// is local to the guess.
    bool is_certain = false;

    /// "phase 'ride', term 'there'"
    std::string name() const;
    /// "2.5 too little at t = 2 s (2 where 4.5 is required)"
    std::string miss() const;
    /// A sentence with name, amount, time, value and bound.
    std::string text() const;
  };

  /// A row of a soft term that is violated at the optimum, and the reason.
  struct SoftShortage {
    /// Largest violation at the optimum, on the side with the larger amount.
    Shortage missed;
    double price = 0.0;  ///< penalty of all violations of the row, both sides and all nodes
    /// Least shortage if all violated soft terms are held to their bounds, in units of the term; 0:
    /// it can hold. Empty: not known.
    std::optional<double> least = {};
    /// Cost of the problem with all violated soft terms made hard, if that is feasible.
    std::optional<double> cost_if_held = {};
    /// Weight of an L1 penalty that holds it, together with those of the other violated terms;
    /// verified.
    std::optional<double> weight_that_holds = {};
    double weight = 0.0;  ///< current weight of its penalty

    /// A sentence with name, amount, time and price.
    std::string text() const;
  };

  /// Changes of the problem that make it feasible.
  struct Remedy {
    std::vector<ProblemChange> changes;  ///< to be applied together
    std::string text;  ///< "with the duration of phase 'ride' 2.6 s in place of 2 s"
    /// Status of the changed problem. A remedy is valid only if that solve succeeded.
    SolveStatus status = SolveStatus::invalid_problem;
    double cost = 0.0;  ///< cost of the changed problem
    /// Change relative to the previous value, or to its nominal magnitude if that is zero.
    double effort = 0.0;
  };

  /// Status of the elastic program. Other values explain something only if it is optimal.
  SolveStatus status = SolveStatus::invalid_problem;
  /// Sum of the amounts divided by their nominal values.
  double relaxation = 0.0;
  std::vector<Shortage> shortages;  ///< largest first, relative to nominal values
  /// Violated soft terms of the optimum if nothing is infeasible, highest price first.
  std::vector<SoftShortage> gives_way;
  double cost = 0.0;  ///< cost of that optimum; 0 if it was not computed
  /// The cost that increases most if all violated soft terms are held: "phase 'ride', 'effort'".
  /// Empty if not known.
  std::string gives_way_to;
  /// Remedies with the least effort first, then the shortages themselves. If only soft terms are
  /// violated, changes that let them hold.
  std::vector<Remedy> remedies;
  /// A phase with events that make its motion discontinuous, so that another guess may help; empty:
  /// none.
  std::string events_in;
  Trajectory trajectory;  ///< least relaxation; for violated soft terms, the optimum
  int solves = 0;         ///< number of solves of elastic and changed problems
  double seconds = 0.0;   ///< wall-clock time

  /// True if the least relaxation was found.
  bool ok() const { return is_success(status); }
  /// True if a shortage was found.
  bool is_infeasible() const { return ok() && !shortages.empty(); }
  /// A sentence per shortage or soft term, and one with the remedies.
  std::string text() const;
};

/// Options of explain().
struct ExplainOptions {
  ShootingOptions shooting = {};  ///< default integrator: Runge-Kutta 4 in two steps
  int remedies = 3;               ///< largest number besides the shortages themselves; 0: none
  double time_limit = 20.0;       ///< wall-clock limit in seconds; 0: none
  /// Factory for the solver; empty: make_native_solver() with tolerance 1e-9.
  std::function<std::unique_ptr<Solver>()> make_solver = {};
  /// Additional initial guess, such as the trajectory of a failed solve.
  std::optional<Trajectory> guess = {};
  bool soft_terms = true;  ///< explain violated soft terms too
  /// True if a number may be changed by a remedy (`by` is not read); false, for example, for
  /// measured values. Empty: every number may change.
  std::function<bool(const ProblemChange&)> may_change = {};
};

/// Throws DefinitionError for invalid problems or options. If functions are not convex, the
/// relaxation is a local minimum near the guess.
Explanation explain(const OptimalControlProblem& problem, const ExplainOptions& options = {});

}  // namespace saltus
