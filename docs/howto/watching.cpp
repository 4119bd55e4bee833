// An observed solve, and a solve that is stopped early.
#include "cart.hpp"

int main() {
  // Prints a table of iterations like that of Ipopt; here only its head and its length.
  int lines = 0;
  const auto print = [&](const std::string& line) {
    if (lines++ == 0) std::printf("%s\n", line.c_str());
  };
  const Solution plan = solve(ride(), {.observer = {.report = table_of_iterations(print)}});
  std::printf("more than one iteration: %s\n", lines > 2 ? "yes" : "no");

  // The observer receives data and may stop the solve.
  double violation = infinity;
  SolveObserver observer;
  observer.report = [&](const SolveObserver::Iteration& it) { violation = it.violation; };
  observer.should_stop = [&] { return violation < 1e-3; };
  const Solution early = solve(ride(), {.observer = observer});
  std::printf("%s; violation below 1e-3: %s\n", describe(early.status),
              early.kkt.feasibility < 1e-3 ? "yes" : "no");
  return plan.ok() && !early.ok() ? 0 : 1;
}
