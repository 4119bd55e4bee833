#include "saltus/solver/solver.hpp"

namespace saltus {

const char* describe(SolveStatus status) {
  switch (status) {
    case SolveStatus::optimal:
      return "an optimum was found to the requested tolerance";
    case SolveStatus::acceptable:
      return "progress stopped at a point that meets the looser, acceptable tolerance";
    case SolveStatus::feasible:
      return "one step towards the optimum was taken: it meets all constraints but is not optimal "
             "yet";
    case SolveStatus::step_taken:
      return "one step towards the optimum was taken, and the constraints are not known to be met";
    case SolveStatus::coarse_grid:
      return "an optimum on the grid was found, but the plan is too inaccurate between its nodes";
    case SolveStatus::wrong_crossing:
      return "an optimum was found, but one of its phases does not end by the declared event";
    case SolveStatus::no_minimum:
      return "the point is stationary but not a minimum: a saddle point or a maximum";
    case SolveStatus::infeasible:
      return "no point that meets all constraints was found; the solve stopped at an apparent "
             "local "
             "minimum of their violation";
    case SolveStatus::unbounded:
      return "the cost is unbounded below within the constraints";
    case SolveStatus::iteration_limit:
      return "the iteration limit was reached";
    case SolveStatus::time_limit:
      return "the wall-clock limit was reached";
    case SolveStatus::interrupted:
      return "the solve was interrupted before its end";
    case SolveStatus::evaluation_failed:
      return "the problem's functions could not be evaluated";
    case SolveStatus::numerical_failure:
      return "the linear algebra or the line search could not make progress";
    case SolveStatus::invalid_problem:
      return "the solver does not accept the problem or the options";
  }
  return "unknown status";
}

SolveStatus to_solve_status(qp::QpStatus status) {
  switch (status) {
    case qp::QpStatus::optimal:
      return SolveStatus::optimal;
    case qp::QpStatus::infeasible:
      return SolveStatus::infeasible;
    case qp::QpStatus::unbounded:
      return SolveStatus::unbounded;
    case qp::QpStatus::iteration_limit:
      return SolveStatus::iteration_limit;
    case qp::QpStatus::deadline:
      return SolveStatus::time_limit;
    case qp::QpStatus::numerical_failure:
      return SolveStatus::numerical_failure;
    case qp::QpStatus::invalid_problem:
      return SolveStatus::invalid_problem;
  }
  return SolveStatus::numerical_failure;
}

}  // namespace saltus
