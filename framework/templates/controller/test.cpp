// Returns 1 with a message if a check fails.
#include <cmath>
#include <cstdio>
#include <saltus/integrators/runge_kutta.hpp>
#include <saltus/simulation/closed_loop.hpp>

#include "problem.hpp"

using namespace saltus;

int main() {
  MultipleShooting shooting{make_problem(),
                            {.intervals_per_phase = 25, .integrator = runge_kutta4()}};
  RecedingHorizonController controller{std::move(shooting), {.period = 0.02}};
  controller.set_data("target", VectorXd::Constant(1, 0.3));
  IntegratorPlant plant = nominal_plant(make_problem(), runge_kutta8());
  const LoopLog log = simulate_closed_loop(controller, plant, {.duration = 5.0});
  const VectorXd end = log.final_state();
  if (!log.completed || std::abs(end[0] - 0.3) > 0.01 || std::abs(end[1]) > 0.01) {
    std::printf("%s: the cart ends at %g m with the pole at %g rad\n", log.message.c_str(), end[0],
                end[1]);
    return 1;
  }
  return 0;
}
