#include "saltus/solve/solve_budget.hpp"

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/native_solver.hpp"

namespace saltus {
namespace {

constexpr double tolerance = 1e-9;  // for elastic programs: shortages are accurate to six digits

}  // namespace

bool is_plan(const Solution& solution) {
  return solution.ok() || solution.status == SolveStatus::coarse_grid;
}

SolveBudget::SolveBudget(const ExplainOptions& options) : options_(options) {
  if (!options_.shooting.integrator) options_.shooting.integrator = runge_kutta4({.steps = 2});
  if (options_.time_limit > 0.0) deadline_ = seconds_after(begin_, options_.time_limit);
}

std::unique_ptr<Solver> SolveBudget::make_solver() const {
  std::unique_ptr<Solver> solver =
      options_.make_solver ? options_.make_solver() : make_native_solver({.tolerance = tolerance});
  solver->set_deadline(deadline_);
  return solver;
}

LeastRelaxation SolveBudget::relax(const OptimalControlProblem& problem, const Trajectory* guess,
                                   const ShootingOptions& grid) {
  ++count_;
  if (guess != nullptr && guess->empty()) guess = nullptr;  // the solve had no plan
  return least_relaxation(problem, grid, *make_solver(), guess, is_negotiable);
}

Solution SolveBudget::plan(MultipleShooting& shooting, const Trajectory& other_guess) {
  ++count_;
  Solution plan = solve(shooting, *make_solver());
  if (is_plan(plan) || is_late() || other_guess.empty()) return plan;
  ++count_;
  return solve(shooting, *make_solver(), shooting.guess_from(other_guess));
}

}  // namespace saltus
