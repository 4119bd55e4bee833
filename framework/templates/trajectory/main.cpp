// Plans the motion, then drives a plant with disturbances along it. The results go to results/plan
// and results/loop; plot.py draws them.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <saltus/saltus.hpp>

#include "problem.hpp"

using namespace saltus;

int main() try {
  const OptimalControlProblem problem = make_problem();
  const Solution plan = solve(problem, {.intervals_per_phase = 60});
  std::printf("plan: %s; cost %.4f\n", plan.message.c_str(), plan.cost);
  Recording recording = record(problem, plan.trajectory);
  recording.state_names = state_names;
  recording.input_names = input_names;
  std::filesystem::create_directories("results/plan");
  std::ofstream("results/plan/trajectory.csv") << recording.trajectory_csv();

  // Solves the remaining problem every 0.05 s from the measured state.
  const ShootingOptions grid{.intervals_per_phase = 60, .integrator = runge_kutta4({.steps = 2})};
  ShrinkingHorizonController controller(
      problem, remaining_controllers(problem, grid, [](MultipleShooting rest) {
        return RecedingHorizonController(std::move(rest), {.period = 0.05});
      }));
  controller.adopt_plan(plan.trajectory);
  PhasedPlant plant(problem, runge_kutta8());
  LoopOptions options{.duration = 4.0, .samples_per_tick = 4};
  options.state_names = state_names;
  options.input_names = input_names;
  options.disturbances.state_noise = VectorXd{{0.002, 0.01}};
  const LoopLog log = simulate_closed_loop(controller, plant, options);
  std::printf("loop: %s; ends at %.3f rad with %.3f rad/s; median of a tick %.2f ms\n",
              log.message.c_str(), log.final_state()[0], log.final_state()[1],
              1e3 * log.statistics.all().quantile(0.5));
  log.write("results/loop");
  return plan.ok() && log.completed ? 0 : 1;
} catch (const DefinitionError& wrong) {
  std::fprintf(stderr, "%s\n", wrong.what());
  return 2;
}
