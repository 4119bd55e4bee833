// A solve that is watched, and one that is ended early.
#include "cart.hpp"

int main() {
  // Every iteration in a table, as one knows it from Ipopt; here only its head and its length.
  int lines = 0;
  const auto print = [&](const std::string& line) {
    if (lines++ == 0) std::printf("%s\n", line.c_str());
  };
  const Solution plan = solve(ride(), {.observer = {.report = table_of_iterations(print)}});
  std::printf("more than one iteration: %s\n", lines > 2 ? "yes" : "no");

  // Or as data; and whoever watches may end it: an interrupt, a better idea.
  double violation = infinity;
  SolveObserver observer;
  observer.report = [&](const SolverIteration& it) { violation = it.violation; };
  observer.should_stop = [&] { return violation < 1e-3; };
  const Solution early = solve(ride(), {.observer = observer});
  std::printf("%s; violation below 1e-3: %s\n", describe(early.status),
              early.kkt.feasibility < 1e-3 ? "yes" : "no");
  return plan.ok() && !early.ok() ? 0 : 1;
}
