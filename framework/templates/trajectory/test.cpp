// Returns 1 with a message if a check fails.
#include <cmath>
#include <cstdio>
#include <numbers>
#include <saltus/solve/solve.hpp>

#include "problem.hpp"

int main() {
  const saltus::Solution plan = saltus::solve(make_problem(), {.intervals_per_phase = 60});
  if (!plan.ok()) {
    std::printf("%s\n", plan.message.c_str());
    return 1;
  }
  const saltus::VectorXd end = plan.trajectory.pieces().back().end_state;
  if (std::abs(end[0] - std::numbers::pi) > 1e-6 || std::abs(end[1]) > 1e-6) {
    std::printf("the pendulum ends at %g rad with %g rad/s\n", end[0], end[1]);
    return 1;
  }
  return 0;
}
