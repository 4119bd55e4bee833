#include "saltus/solver/solve_in_scale.hpp"

#include <algorithm>
#include <utility>

#include "saltus/solver/scaled_program.hpp"
#include "saltus/solver/scoped_observer.hpp"

namespace saltus {
namespace {

// Residuals in the scale of a solution's values: what is small, and what is no optimum.
constexpr double small = 1e-8, doubtful = 1e-5;
constexpr double much_larger = 100.0;  // than in the scale of the solver

KktResidual residual_in(NonlinearProgram& program, const ProgramScale& scale,
                        const NlpPoint& point) {
  ScaledProgram in_scale(program, scale);
  return kkt_residual(in_scale, in_scale.to_scaled(point));
}

NlpResult solve_once(Solver& solver, NonlinearProgram& program, const ProgramScale& scale,
                     const NlpPoint& start, bool warm, KktResidual& residual) {
  if (scale.is_one()) {
    NlpResult result = solver.solve(program, start, warm);
    residual = result.kkt;
    return result;
  }
  ScaledProgram in_scale(program, scale);
  NlpResult result;
  {
    const ScopedObserver observed(solver, with_cost_times(solver.observer(), 1.0 / scale.cost));
    result = solver.solve(in_scale, in_scale.to_scaled(start), warm);
  }
  residual = result.kkt;
  result.point = in_scale.from_scaled(std::move(result.point));
  if (!program.objective(result.point.w.data(), result.objective) && is_success(result.status))
    result.status = SolveStatus::evaluation_failed;
  result.kkt = kkt_residual(program, result.point);
  return result;
}

bool may_be_mended(SolveStatus status) {
  return status == SolveStatus::infeasible || status == SolveStatus::iteration_limit ||
         status == SolveStatus::numerical_failure || status == SolveStatus::unbounded;
}

}  // namespace

ScaledResult solve_in_scale(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                            bool warm, const Quantities& quantities) {
  ProgramSize size(program, quantities);
  ScaledResult result;
  if (!size.look_at(start.w)) {
    result.nlp = solve_once(solver, program, {1.0, VectorXd::Ones(program.rows())}, start, warm,
                            result.in_scale);
    return result;
  }
  ProgramScale scale = size.usual();
  if (!size.is_usual_where_known(scale)) scale = size.to_one();
  result.nlp = solve_once(solver, program, scale, start, warm, result.in_scale);

  for (const bool is_last : {false, false, true}) {
    const bool is_solved = is_success(result.nlp.status);
    if (is_solved) {
      const double in_solver = result.in_scale.scaled();
      if (!size.look_at(result.nlp.point.w) || size.is_usual_where_known(scale)) return result;
      result.in_scale = residual_in(program, size.to_one(), result.nlp.point);
      result.is_doubtful = result.in_scale.scaled() > std::max(doubtful, much_larger * in_solver);
      if (result.in_scale.scaled() <= std::max(small, much_larger * in_solver)) return result;
    } else if (!may_be_mended(result.nlp.status) || !size.is_far_from_usual(scale)) {
      return result;
    }
    if (is_last) return result;
    ScaledResult again;
    scale = size.to_one();
    again.nlp = solve_once(solver, program, scale, start, warm, again.in_scale);
    again.nlp.iterations += result.nlp.iterations;
    again.nlp.seconds += result.nlp.seconds;
    if (is_solved && !is_success(again.nlp.status)) return result;
    result = std::move(again);
  }
  return result;
}

}  // namespace saltus
