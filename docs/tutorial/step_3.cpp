// Step 3: two phases. Push off and fly; both durations are unknowns.
#include "hopper.hpp"

int main() {
  Phase<2, 1> push = stance("push off", between(0.05, 1.0));
  push.ends_when("lift-off", off_the_ground, Crossing::rising).guess_duration(0.3);
  Phase<2, 0> fly{"rise in the air", Flight{}, between(0.05, 2.0)};
  fly.ends_when("apex", speed, Crossing::falling)
      .reach("high enough", height, at_least(0.75))
      .guess_duration(0.2);

  OptimalControlProblem problem("jump");
  problem.start_at({0.3, 0.0}).then(push).then(fly);

  const Solution plan = solve(problem);
  std::printf("%s\n", plan.message.c_str());
  std::printf("lift-off after %.4f s, apex after %.4f s\n", plan.durations[0],
              plan.durations[0] + plan.durations[1]);
  save(problem, plan, "step_3", state_names, input_names);
  return plan.ok() ? 0 : 1;
}
