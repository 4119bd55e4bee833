#include "saltus/solver/solver.hpp"

namespace saltus {

const char* describe(SolveStatus status) {
  switch (status) {
    case SolveStatus::optimal:
      return "an optimum was found to the requested tolerance";
    case SolveStatus::acceptable:
      return "progress stopped at a point that meets the looser, acceptable tolerance";
    case SolveStatus::feasible:
      return "one step towards the optimum was taken: it meets all constraints, but is no optimum "
             "yet";
    case SolveStatus::step_taken:
      return "one step towards the optimum was taken, and the constraints are not known to be met";
    case SolveStatus::coarse_grid:
      return "an optimum on the grid was found, but between its nodes the plan is not one";
    case SolveStatus::wrong_crossing:
      return "an optimum was found, but a phase of it does not end by the event that was declared";
    case SolveStatus::no_minimum:
      return "the point is stationary but no minimum: a saddle or a maximum";
    case SolveStatus::infeasible:
      return "no point that meets all constraints was found near the guess";
    case SolveStatus::unbounded:
      return "the cost decreases without limit within the constraints";
    case SolveStatus::iteration_limit:
      return "the iteration limit was reached first";
    case SolveStatus::time_limit:
      return "the wall-clock limit was reached first";
    case SolveStatus::interrupted:
      return "the solve was interrupted before its end";
    case SolveStatus::evaluation_failed:
      return "the problem's functions could not be evaluated";
    case SolveStatus::numerical_failure:
      return "the linear algebra or the line search could not make progress";
    case SolveStatus::invalid_problem:
      return "the problem or the options cannot be accepted by the solver";
  }
  return "unknown status";
}

SolveStatus to_solve_status(QpStatus status) {
  switch (status) {
    case QpStatus::optimal:
      return SolveStatus::optimal;
    case QpStatus::infeasible:
      return SolveStatus::infeasible;
    case QpStatus::unbounded:
      return SolveStatus::unbounded;
    case QpStatus::iteration_limit:
      return SolveStatus::iteration_limit;
    case QpStatus::deadline:
      return SolveStatus::time_limit;
    case QpStatus::numerical_failure:
      return SolveStatus::numerical_failure;
    case QpStatus::invalid_problem:
      return SolveStatus::invalid_problem;
  }
  return SolveStatus::numerical_failure;
}

}  // namespace saltus
