// Prints the results of C++ with which tests compare those of Python: for each problem of the
// library that is named, its cost, durations and final state.
#include <cstdio>
#include <cstring>

#include "problems/library/catalogue.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

int main(int count, char** names) {
  for (int i = 1; i < count; ++i)
    for (const saltus::ReferenceCase& c : saltus::reference_cases()) {
      if (c.name != names[i]) continue;
      saltus::MultipleShooting shooting(c.problem(), c.options);
      const auto solver = saltus::make_native_solver({.tolerance = 1e-10});
      const saltus::Solution plan = saltus::solve(shooting, *solver);
      std::printf("%s %.17g", names[i], plan.cost);
      for (const double duration : plan.durations) std::printf(" %.17g", duration);
      for (const double x : plan.trajectory.final_state()) std::printf(" %.17g", x);
      std::printf("\n");
    }
}
