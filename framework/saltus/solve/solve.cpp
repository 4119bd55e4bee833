#include "saltus/solve/solve.hpp"

#include <utility>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/solver/scoped_observer.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

namespace {

IntegratorChoice default_integrator() { return runge_kutta4({.steps = 2}); }

}  // namespace

SolveOptions::operator ShootingOptions() const {
  return {.intervals_per_phase = intervals_per_phase,
          .intervals = intervals,
          .integrator = integrator ? integrator : default_integrator(),
          .threads = threads};
}

Solution solve(const OptimalControlProblem& problem, const SolveOptions& options) {
  MultipleShooting shooting(problem, options);
  const std::shared_ptr<Solver> solver = options.solver ? options.solver : make_native_solver();
  const bool is_watched = options.observer.report || options.observer.should_stop;
  const ScopedObserver watched(*solver, is_watched ? options.observer : solver->observer());
  return options.guess ? solve(shooting, *solver, shooting.guess_from(*options.guess))
                       : solve(shooting, *solver);
}

Solution solve_on(const OptimalControlProblem& problem, const ShootingOptions& grid) {
  ShootingOptions options = grid;
  if (!options.integrator) options.integrator = default_integrator();
  MultipleShooting shooting(problem, std::move(options));
  return solve(shooting, *make_native_solver());
}

}  // namespace saltus
