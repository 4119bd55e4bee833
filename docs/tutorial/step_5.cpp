// Step 5: a periodic motion. The start and the duration of a hop are unknowns.
#include "hopper.hpp"

int main() {
  Phase<2, 1> bounce = stance("bounce", between(0.1, 1.0));
  bounce.ends_when("lift-off", off_the_ground, Crossing::rising)
      .reach("fast enough", apex, at_least(0.75))
      .guess_duration(0.4)
      .guess_state(Guess::interpolate(VectorXd{{leg, -2.0}}, VectorXd{{leg, 2.0}}));
  Phase<2, 0> fly = flight("fly");
  fly.guess_state(Guess::interpolate(VectorXd{{leg, 2.0}}, VectorXd{{leg, -2.0}}));

  OptimalControlProblem problem("periodic hop");
  problem.start_within({exactly(leg), between(-4.0, -0.5)}, VectorXd{{leg, -2.0}})
      .then(bounce)
      .then(fly)
      .close(jump<2>("landing", landing));

  const Solution plan = solve(problem);
  std::printf("%s\n", plan.message.c_str());
  std::printf("lands with %.4f m/s; on the ground %.4f s, in the air %.4f s\n",
              plan.trajectory.state(0.0)[1], plan.durations[0], plan.durations[1]);
  save(problem, plan, "step_5", state_names, input_names);
  return plan.ok() ? 0 : 1;
}
