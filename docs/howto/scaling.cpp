// A badly scaled problem, the verdict of the check, and nominal magnitudes.
#include <saltus/solve/check.hpp>

#include "cart.hpp"

// A satellite rises by 100 km in one hour; units are metres and seconds.
OptimalControlProblem rise(bool has_magnitudes) {
  const auto motion = [](auto, auto x, auto u) { return decltype(x){x[1], u[0]}; };
  Phase<2, 1> phase{"rise", motion, exactly(3600.0)};
  phase.bound_input(0, between(-1.0, 1.0))
      .track("effort", pull, VectorXd::Ones(1))
      .reach("there", position, exactly(7.1e6))
      .reach("at rest", speed, exactly(0.0));
  if (has_magnitudes) phase.nominal(VectorXd{{1e6, 100.0}}, VectorXd::Constant(1, 0.1));
  OptimalControlProblem problem(has_magnitudes ? "with magnitudes" : "without");
  problem.start_at({7.0e6, 0.0}).then(phase);
  return problem;
}

int main() {
  for (const bool has_magnitudes : {false, true}) {
    const ProblemCheck page = check(rise(has_magnitudes));
    std::printf("%s: %s\n", page.problem.c_str(), page.line("scaling").text.c_str());
    std::printf("  cost %.4f\n", solve(rise(has_magnitudes)).cost);
  }
  return 0;
}
