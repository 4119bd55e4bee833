// Plans once, then closes the loop: every 20 ms one step of the real-time iteration. The target
// moves, the cart is pushed and the measurements are noisy. The results go to results/plan and
// results/loop; plot.py draws them.
#include <cstdio>
#include <filesystem>
#include <fstream>
#include <saltus/saltus.hpp>

#include "problem.hpp"

using namespace saltus;

int main() try {
  const OptimalControlProblem problem = make_problem();
  const Solution plan = solve(problem);
  std::printf("plan: %s; cost %.4f\n", plan.message.c_str(), plan.cost);
  Recording recording = record(problem, plan.trajectory);
  recording.state_names = state_names;
  recording.input_names = input_names;
  std::filesystem::create_directories("results/plan");
  std::ofstream("results/plan/trajectory.csv") << recording.trajectory_csv();

  MultipleShooting shooting{problem, {.intervals_per_phase = 25, .integrator = runge_kutta4()}};
  RecedingHorizonController controller{std::move(shooting), {.period = 0.02, .deadline = 0.02}};
  IntegratorPlant plant = nominal_plant(problem, runge_kutta8());
  LoopOptions options{.duration = 8.0};
  options.state_names = state_names;
  options.input_names = input_names;
  options.before_tick = [&](double t, const VectorRef&) {
    controller.set_data("target", VectorXd::Constant(1, t < 2.0 ? 0.0 : 0.5));
  };
  options.disturbances.input = [](double t, const VectorRef&, VectorOut added) {
    if (t >= 5.0 && t < 5.1) added[0] = 8.0;  // a push
  };
  options.disturbances.measurement_noise = VectorXd{{0.001, 0.002, 0.005, 0.01}};
  const LoopLog log = simulate_closed_loop(controller, plant, options);
  const LatencyHistogram times = log.statistics.all();
  std::printf(
      "loop: %s; ends at %.3f m, pole at %.3f rad; tick: median %.2f ms, 99 %% %.2f ms; "
      "%d of %zu without a new plan\n",
      log.message.c_str(), log.final_state()[0], log.final_state()[1], 1e3 * times.quantile(0.5),
      1e3 * times.quantile(0.99), log.count(Provenance::shifted) + log.count(Provenance::fallback),
      log.ticks.size());
  log.write("results/loop");
  return plan.ok() && log.completed ? 0 : 1;
} catch (const DefinitionError& wrong) {
  std::fprintf(stderr, "%s\n", wrong.what());
  return 2;
}
