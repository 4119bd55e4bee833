// Repeated solves with other data: each one starts from the last solution.
#include "cart.hpp"

int main() {
  MultipleShooting shooting{ride(), {.intervals_per_phase = 40, .integrator = runge_kutta4()}};
  const std::unique_ptr<Solver> solver = make_native_solver();
  const Solution first = solve(shooting, *solver);

  shooting.start_at(0.0, VectorXd{{0.1, 0.2}});  // the new start
  const Solution cold = solve(shooting, *solver);
  const Solution warm = solve(shooting, *solver, first.point);
  std::printf("the same cost: %s; fewer iterations: %s\n",
              std::abs(warm.cost - cold.cost) < 1e-7 ? "yes" : "no",
              warm.iterations < cold.iterations ? "yes" : "no");

  // On another grid the trajectory is the guess, without multipliers.
  MultipleShooting finer{ride(), {.intervals_per_phase = 160, .integrator = runge_kutta4()}};
  const Solution refined = solve(finer, *solver, finer.guess_from(first.trajectory));
  std::printf("%.4f on 40 intervals, %.4f on 160\n", first.cost, refined.cost);

  // A sequence of easier problems leads to a hard one.
  Solution farther = first;
  for (double distance = 1.2; distance < 2.05; distance += 0.2)
    farther = solve(ride(distance), {.guess = farther.trajectory});
  std::printf("2 m: %s\n", farther.message.c_str());
  return warm.ok() && refined.ok() && farther.ok() ? 0 : 1;
}
