// Derivatives of an optimum with respect to the start, a parameter and a duration.
#include <saltus/transcription/optimum_derivatives.hpp>

#include <cmath>

#include "cart.hpp"

int main() {
  MultipleShooting shooting{ride(), {.intervals_per_phase = 40, .integrator = runge_kutta4()}};
  const std::unique_ptr<Solver> solver = make_native_solver({.tolerance = 1e-10});
  const Solution plan = solve(shooting, *solver);

  OptimumDerivatives derivatives(shooting, plan);
  const OptimumDerivatives::Derivative start = derivatives.wrt_start(1);  // initial speed, m/s
  const OptimumDerivatives::Derivative duration = derivatives.wrt_duration(0);
  std::printf("reliable: %s\n", start.reliable && duration.reliable ? "yes" : "no");
  std::printf("per m/s of initial speed: cost %.3f, first input %.3f m/s^2\n", start.cost,
              start.first_input[0]);
  std::printf("per s of duration: cost %.3f\n", duration.cost);

  // A new solve confirms the first-order prediction.
  shooting.start_at(0.0, VectorXd{{0.0, 0.01}});
  const Solution moved = solve(shooting, *solver, plan.point);
  const double predicted = plan.cost + 0.01 * start.cost;
  std::printf("prediction within 1e-3: %s\n",
              std::abs(moved.cost - predicted) < 1e-3 ? "yes" : "no");
  return start.reliable && std::abs(moved.cost - predicted) < 1e-3 ? 0 : 1;
}
