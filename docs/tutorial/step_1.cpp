// Step 1: one phase. From a crouch to standing in half a second with minimum effort.
#include "hopper.hpp"

int main() {
  Phase<2, 1> rise = stance("rise", exactly(0.5));
  rise.reach("straight", height, exactly(leg)).reach("at rest", speed, exactly(0.0));

  OptimalControlProblem problem("stand up");
  problem.start_at({0.3, 0.0}).then(rise);

  const Solution plan = solve(problem);
  std::printf("%s\n", plan.message.c_str());
  std::printf("force: %.1f N at the start, %.1f N at the end; weight: %.1f N\n",
              plan.trajectory.input(0.0)[0], plan.trajectory.input(0.499)[0], mass * gravity);
  save(problem, plan, "step_1", state_names, input_names);
  return plan.ok() ? 0 : 1;
}
