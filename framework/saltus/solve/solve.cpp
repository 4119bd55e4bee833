#include "saltus/solve/solve.hpp"

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/scoped_observer.hpp"
#include "saltus/solver/sqp.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

Solution solve(const OptimalControlProblem& problem, const SolveOptions& options) {
  MultipleShooting shooting(
      problem, {.intervals_per_phase = options.intervals_per_phase,
                .intervals = options.intervals,
                .integrator = options.integrator ? options.integrator : runge_kutta4({.steps = 2}),
                .threads = options.threads});
  const std::shared_ptr<Solver> solver = options.solver ? options.solver : make_sqp();
  const bool is_watched = options.observer.report || options.observer.should_stop;
  const ScopedObserver watched(*solver, is_watched ? options.observer : solver->observer());
  return options.guess ? solve(shooting, *solver, shooting.guess_from(*options.guess))
                       : solve(shooting, *solver);
}

}  // namespace saltus
