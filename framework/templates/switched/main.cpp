// Plans through the switch, then drives a plant with more friction on the gravel than planned. The
// results go to results/plan and results/loop; plot.py draws them.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <saltus/saltus.hpp>

#include "problem.hpp"

using namespace saltus;

int main() try {
  const OptimalControlProblem problem = make_problem();
  const Solution plan = solve(problem);
  std::printf("plan: %s; %.3f s on ice, %.3f s on gravel\n", plan.message.c_str(),
              plan.durations[0], plan.durations[1]);
  Recording recording = record(problem, plan.trajectory);
  recording.state_names = state_names;
  recording.input_names = input_names;
  std::filesystem::create_directories("results/plan");
  std::ofstream("results/plan/trajectory.csv") << recording.trajectory_csv();

  // Solves the remaining problem every 0.05 s from the measured state. The plant reports when the
  // gravel begins.
  const ShootingOptions grid{.intervals_per_phase = 30, .integrator = runge_kutta4({.steps = 2})};
  ShrinkingHorizonController controller(
      problem, remaining_controllers(problem, grid, [](MultipleShooting rest) {
        return RecedingHorizonController(std::move(rest), {.period = 0.05});
      }));
  controller.adopt_plan(plan.trajectory);
  PhasedPlant plant(make_problem(0.33), runge_kutta8());
  LoopOptions options{.duration = 20.0, .samples_per_tick = 4};
  options.state_names = state_names;
  options.input_names = input_names;
  const LoopLog log = simulate_closed_loop(controller, plant, options);
  std::printf("loop: %s; ends at %.3f m with %.3f m/s; median of a tick %.2f ms\n",
              log.message.c_str(), log.final_state()[0], log.final_state()[1],
              1e3 * log.statistics.all().quantile(0.5));
  log.write("results/loop");
  return plan.ok() && log.completed ? 0 : 1;
} catch (const DefinitionError& wrong) {
  std::fprintf(stderr, "%s\n", wrong.what());
  return 2;
}
