// One program, several solvers.
#include <saltus/solver/ipopt.hpp>

#include "cart.hpp"

int main() {
  MultipleShooting shooting{ride(), {.intervals_per_phase = 40, .integrator = runge_kutta4()}};

  const std::shared_ptr<Solver> solvers[] = {
      make_native_solver(),                                          // sparse factorisation
      make_native_solver({.tolerance = 1e-10, .qp = riccati_qp()}),  // stage by stage
      make_ipopt({.tolerance = 1e-9}),
  };
  bool is_good = true;
  for (const std::shared_ptr<Solver>& solver : solvers) {
    const Solution plan = solve(shooting, *solver);
    std::printf("cost %.6f, residual below 1e-7: %s (%s)\n", plan.cost,
                plan.kkt.scaled() < 1e-7 ? "yes" : "no", describe(plan.status));
    is_good = is_good && plan.ok();
  }
  return is_good ? 0 : 1;
}
