// Step 6: control. Four hops and a landing, with a disturbance in flight.
#include "hopper.hpp"

int main() {
  OptimalControlProblem problem("four hops");
  problem.start_at({leg, -2.1});
  for (int hop = 1; hop <= 4; ++hop) {
    const std::string number = std::to_string(hop);
    Phase<2, 1> bounce = stance("bounce " + number, between(0.05, 1.0));
    bounce.ends_when("lift-off", off_the_ground, Crossing::rising)
        .reach("fast enough", apex, exactly(0.75))
        .guess_duration(0.4)
        .guess_state(Guess::interpolate(VectorXd{{leg, -2.1}}, VectorXd{{leg, 2.2}}));
    Phase<2, 0> fly = flight("fly " + number);
    fly.guess_state(Guess::interpolate(VectorXd{{leg, 2.2}}, VectorXd{{leg, -2.2}}));
    if (hop == 1)
      problem.then(bounce);
    else
      problem.then(bounce, jump<2>("landing", landing));
    problem.then(fly);
  }
  Phase<2, 1> land = stance("land", between(0.05, 1.0));
  land.reach("crouch", height, exactly(0.3)).reach("at rest", speed, exactly(0.0));
  land.guess_state(Guess::interpolate(VectorXd{{leg, -2.1}}, VectorXd{{0.3, 0.0}}));
  problem.then(land, jump<2>("landing", landing));
  const Solution plan = solve(problem, {.intervals_per_phase = 15});
  std::printf("plan: %s\n", plan.message.c_str());

  // Every 10 ms the rest of the motion is planned from the measured state.
  const ShootingOptions grid{.intervals_per_phase = 15, .integrator = runge_kutta4()};
  ShrinkingHorizonController controller(
      problem, remaining_controllers(problem, grid, [](MultipleShooting rest) {
        return RecedingHorizonController(std::move(rest), {.period = 0.01});
      }));
  controller.adopt_plan(plan.trajectory);
  PhasedPlant plant(problem, runge_kutta4());

  double highest = 0.0;
  LoopOptions options{.duration = 5.0};
  options.state_names = state_names;
  options.input_names = input_names;
  options.disturbances.state = [&](double t, const VectorRef&, VectorOut added) {
    if (std::abs(t - 1.45) < 1e-6) added[1] = -1.0;  // m/s
  };
  options.before_tick = [&](double, const VectorRef& x) { highest = std::max(highest, x[0]); };
  options.on_event = [&](const HybridEvent& event) {
    if (event.name == "touch-down") {
      std::printf("touch-down at %.3f s, after %.3f m\n", event.time, highest);
      highest = 0.0;
    }
  };
  const LoopLog log = simulate_closed_loop(controller, plant, options);
  std::printf("%s; ends at %.3f m with %.3f m/s\n", log.message.c_str(), log.final_state()[0],
              log.final_state()[1]);
  log.write("step_6");
  return plan.ok() && log.completed ? 0 : 1;
}
