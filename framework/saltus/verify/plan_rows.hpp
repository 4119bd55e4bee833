// Hard rows of a problem for the verifier: their windows and tolerances.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/verify/formula_bounds.hpp"
#include "saltus/verify/verification.hpp"
#include "saltus/verify/verify.hpp"

namespace saltus {

/// One output of a path constraint with its tolerances.
struct PathRow {
  Bounds bounds;                                ///< infinite from 1e19 on
  double lower_at_node, upper_at_node;          ///< tolerances of the bounds at nodes
  double lower_between, upper_between;          ///< tolerances between nodes
  double lower_found = 0.0, upper_found = 0.0;  ///< largest violations in the current interval
  double lower_time = 0.0, upper_time = 0.0;    ///< their times in seconds
  double least = infinity, most = -infinity;    ///< range of the row along the phase
  bool reads_states_alone = true;               ///< true: not checked at a given start
};

/// A path constraint of a phase: a term, or a bound on one state.
struct PathConstraint {
  std::string name;        ///< name of the term, or "bounds of state 0"
  Function function = {};  ///< z = (t | x | u | p); empty: the state itself
  int state = -1;          ///< bound on this state; -1: a term
  bool reads_input = false;
  Window window = {};
  std::vector<PathRow> rows = {};
  std::optional<FormulaBounds> formula = {};  ///< empty: only values and slopes are known
  std::vector<int> arguments = {};            ///< entries of z that the formula depends on
};

/// All hard path constraints of a phase.
std::vector<PathConstraint> path_constraints(const PhaseDefinition& phase,
                                             const GridAccuracy& accuracy);
/// The rows of `function` without bounds, for a search of its values. Empty unless its elementary
/// steps are known.
std::optional<PathConstraint> values_of(const Function& function);
/// True if the window is open at the midpoint of an interval of the phase that starts at
/// `phase_start`.
bool is_open(const Window& window, const Schedule& schedule, double phase_start,
             const Plan::Interval& interval);
/// Tolerance of one bound of a row (GridAccuracy::rows).
double bound_tolerance(double bound, double nominal, const GridAccuracy& accuracy);
/// Violation of the bounds by a value; infinite for NaN.
double beyond(double value, const Bounds& bounds);

/// Units of the state errors of each phase: the declared nominal magnitude, or else the largest
/// magnitude along the plan if that is below 1. At least 1e-9.
std::vector<VectorXd> units_of_states(const OptimalControlProblem& problem, const Plan& plan);

}  // namespace saltus
