// Step 4: a jump of the state. Push off, fly, land, and come to rest in a crouch.
#include "hopper.hpp"

int main() {
  Phase<2, 1> push = stance("push off", between(0.05, 1.0));
  push.ends_when("lift-off", off_the_ground, Crossing::rising)
      .reach("fast enough", apex, at_least(0.75))
      .guess_duration(0.3);
  Phase<2, 1> land = stance("land", between(0.05, 1.0));
  land.reach("crouch", height, exactly(0.3)).reach("at rest", speed, exactly(0.0));

  OptimalControlProblem problem("hop");
  problem.start_at({0.3, 0.0})
      .then(push)
      .then(flight("fly"))
      .then(land, jump<2>("landing", landing));

  const Solution plan = solve(problem);
  std::printf("%s\n", plan.message.c_str());
  std::printf("push off %.4f s, fly %.4f s, land %.4f s\n", plan.durations[0], plan.durations[1],
              plan.durations[2]);
  save(problem, plan, "step_4", state_names, input_names);
  return plan.ok() ? 0 : 1;
}
