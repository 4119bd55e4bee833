// The hard rows of a problem as the verifier reads them: where they act and their tolerances.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/verify/accuracy.hpp"
#include "saltus/verify/formula_bounds.hpp"
#include "saltus/verify/plan.hpp"

namespace saltus {

/// One output of a path constraint with its tolerances.
struct PathRow {
  Bounds bounds;                                ///< infinite from 1e19 on
  double lower_at_node, upper_at_node;          ///< tolerance of either bound at nodes
  double lower_between, upper_between;          ///< and between them
  double lower_found = 0.0, upper_found = 0.0;  ///< largest violation in the present interval
  double lower_time = 0.0, upper_time = 0.0;    ///< s, where that is
  double least = infinity, most = -infinity;    ///< what the row was seen to take along the phase
  bool reads_state = true;                      ///< a given start is not asked to meet such rows
};

/// A path constraint of a phase: a term, or a bound on one state.
struct PathConstraint {
  std::string name;        ///< of the term, or "bounds of state 0"
  Function function = {};  ///< z = (t | x | u | p); empty: the state itself
  int state = -1;          ///< bound on this state; -1: a term
  bool reads_input = false;
  Window window = {};
  std::vector<PathRow> rows = {};
  std::optional<FormulaBounds> formula = {};  ///< empty: only values and slopes are known
  std::vector<int> arguments = {};            ///< entries of z that the formula reads
};

/// All hard path constraints of a phase.
std::vector<PathConstraint> path_constraints(const PhaseDefinition& phase,
                                             const GridAccuracy& accuracy);
/// True if the window is open in the middle of an interval of the phase that begins at `start`.
bool is_open(const Window& window, const Schedule& schedule, double phase_start,
             const PlannedInterval& interval);
/// Tolerance of one bound of a row (GridAccuracy::rows).
double tolerance_of(double bound, double nominal, const GridAccuracy& accuracy);
/// How far a value is beyond its bounds; infinite if it is not a number.
double beyond(double value, const Bounds& bounds);

/// Magnitudes that errors of the states of each phase are relative to: the nominal magnitude where
/// one is declared, otherwise the largest along the plan if that is below 1. At least 1e-9.
std::vector<VectorXd> units_of_states(const OptimalControlProblem& problem, const Plan& plan);

}  // namespace saltus
