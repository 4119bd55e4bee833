// Step 2: a phase that ends by its state. Push off until the leg is straight.
#include "hopper.hpp"

int main() {
  Phase<2, 1> push = stance("push off", between(0.05, 1.0));
  push.ends_when("lift-off", off_the_ground, Crossing::rising)
      .reach("fast enough", apex, at_least(0.75))
      .guess_duration(0.3);

  OptimalControlProblem problem("push off");
  problem.start_at({0.3, 0.0}).then(push);

  const Solution plan = solve(problem);
  std::printf("%s\n", plan.message.c_str());
  std::printf("lift-off after %.4f s\n", plan.durations[0]);
  for (const Solution::GuardCrossing& crossing : plan.crossings)
    std::printf("'%s' at %.3f m/s\n", crossing.event.c_str(), crossing.rate);
  save(problem, plan, "step_2", state_names, input_names);
  return plan.ok() ? 0 : 1;
}
