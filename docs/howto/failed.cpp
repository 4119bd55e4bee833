// Failed solves and their messages.
#include "cart.hpp"

int main() {
  // The force is too small for this distance.
  const Solution far = solve(ride(5.0));
  std::printf("%s\n\n", far.message.c_str());

  // The smallest relaxation, and possible changes.
  const Explanation why = explain(ride(5.0));
  std::printf("%s", why.text().c_str());
  const Solution longer = solve(changed(ride(5.0), why.remedies.front().changes.front()));
  std::printf("with the first of these: %s\n\n", describe(longer.status));

  // The same with a soft target: the distance that is reached, and the reason.
  Phase<2, 1> phase{"ride", Cart{}, exactly(2.0)};
  phase.bound_input(0, between(-3.0, 3.0))
      .track("effort", pull, VectorXd::Ones(1))
      .reach("there", position, exactly(5.0), soft("place", 100.0))
      .reach("at rest", speed, exactly(0.0));
  OptimalControlProblem problem("soft target");
  problem.start_at({0.0, 0.0}).then(phase);
  const Solution near = solve(problem);
  for (const Solution::SoftViolation& missed : near.soft_violations)
    std::printf("'%s' is missed by %.3f\n", missed.term.c_str(), missed.largest);
  std::printf("%s", explain(problem).text().c_str());
  return far.status == SolveStatus::infeasible && longer.ok() && near.ok() ? 0 : 1;
}
