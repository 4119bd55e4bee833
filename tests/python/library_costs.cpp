// Prints the results of C++ with which tests compare those of Python: for each problem of the
// library that is named, its cost, durations and final state.
#include <cstdio>
#include <cstring>

#include "problems/library/catalogue.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

int main(int count, char** names) {
  using namespace saltus;
  for (int i = 1; i < count; ++i)
    for (const ReferenceCase& c : reference_cases()) {
      if (c.name != names[i]) continue;
      MultipleShooting shooting(c.problem(), c.options);
      const auto solver = make_native_solver({.tolerance = 1e-10});
      const Solution plan = solve(shooting, *solver);
      std::printf("%s %.17g", names[i], plan.cost);
      for (const double duration : plan.durations) std::printf(" %.17g", duration);
      for (const double x : plan.trajectory.final_state()) std::printf(" %.17g", x);
      std::printf("\n");
    }
}
