// Returns 1 with a message if a check fails.
#include <cmath>
#include <cstdio>
#include <saltus/solve/solve.hpp>

#include "problem.hpp"

int main() {
  const saltus::Solution plan = saltus::solve(make_problem());
  if (!plan.ok()) {
    std::printf("%s\n", plan.message.c_str());
    return 1;
  }
  const auto& pieces = plan.trajectory.pieces();
  const double switched = plan.trajectory.state(plan.durations[0])[0];
  const saltus::VectorXd end = pieces.back().end_state;
  if (std::abs(switched - gravel_begins) > 1e-6 || std::abs(end[0] - finish) > 1e-6) {
    std::printf("the gravel begins at %g m, and the sledge stops at %g m\n", switched, end[0]);
    return 1;
  }
  return 0;
}
