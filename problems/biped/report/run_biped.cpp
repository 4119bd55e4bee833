#include "problems/biped/report/run_biped.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "problems/biped/report/body_output.hpp"
#include "problems/biped/report/run_summary.hpp"
#include "problems/biped/report/scripts.hpp"
#include "problems/biped/report/unmet.hpp"
#include "saltus/app/defer_signals.hpp"
#include "saltus/core/error.hpp"
#include "saltus/robots/walking/body_verdict.hpp"
#include "saltus/robots/walking/hardware_limits.hpp"
#include "saltus/robots/walking/progress.hpp"
#include "saltus/robots/walking/settling.hpp"

namespace saltus::robots::walking {
namespace {

using Json = nlohmann::ordered_json;

// Empty without a landing.
std::string settling_text(const RunLog& log, const Verdict& verdict, const ForceSettling& forces) {
  if (log.touchdown == infinity) return {};
  const auto seconds = [](double t) {
    return t < infinity ? fmt::format("{:.2f} s", t) : std::string("never");
  };
  std::string text = fmt::format(
      "touch-down at {:.3f} s; settling times from {:.3f} s on: capture point {}, planned forces "
      "{}",
      log.touchdown, verdict.settled_from, seconds(verdict.icp_settling),
      seconds(forces.planned.maxCoeff()));
  if (!log.body.empty()) text += fmt::format(", measured {}", seconds(forces.measured.maxCoeff()));
  return text + "\n";
}

// Prints a note on changed keys that have no effect on the centroidal model.
void note_keys_of_the_body(const Json& changed) {
  constexpr std::array sections = {
      "simulator.", "motor.",  "drive", "model.rotor_inertia", "model.friction",     "swing.",
      "sensors",    "sensor.", "dart.", "self_collision",      "joint_speed_limits", "push.link",
      "push.point"};
  std::vector<std::string> unused;
  for (const Json& setting : changed) {
    const std::string key = setting["key"];
    if (std::ranges::any_of(sections,
                            [&](const char* section) { return key.starts_with(section); }))
      unused.push_back(key);
  }
  if (!unused.empty())
    fmt::print(stderr,
               "these settings have no effect on the centroidal model: {} (use --plant dart)\n",
               fmt::join(unused, ", "));
}

}  // namespace

ExitStatus run_biped(const BipedProblem& problem, const std::string& default_config,
                     const RunContext& context) {
  const BipedSettings& settings = problem.settings();
  const bool has_body = settings.plant.is_whole_body();
  const RobotDescription robot = robot_of(settings);
  for (const std::string& warning : robot.warnings) fmt::print(stderr, "warning: {}\n", warning);
  fmt::print("robot: {}, {:.2f} kg ({})\n", robot.name, robot.mass, robot.source);
  for (const Push& push : problem.pushes())
    fmt::print("push: {} N s in {} s at {} s\n", push.impulse, push.duration, push.start);

  const bool measured = has_body && settings.plant.sensors == PlantSettings::Sensors::measured;
  if (measured) fmt::print("sensors: measured, seed {}\n", settings.plant.sensor.seed);
  const Json changed = changed_settings(context.effective_config, default_config);
  if (!has_body) note_keys_of_the_body(changed);

  Progress progress(stdout, isatty(fileno(stdout)) != 0);
  int signal = 0;
  const RunLog log = [&] {
    const DeferSignals note;
    RunLog result = simulate(problem, robot, [&progress](const LoopState& state) {
      progress.show(state);
      return DeferSignals::received() == 0;
    });
    signal = DeferSignals::received();
    return result;
  }();
  progress.finish();
  const Verdict verdict = problem.judge(log);
  const ForceSettling settling = force_settling(log, verdict.settled_from);
  Json json = summary(settings, log, verdict);
  json["force_settling"] = to_json(settling);
  json["changed_settings"] = changed;
  UnmetReport unmet;
  if (signal == 0)
    unmet = explain_unmet(*problem.unmet_explanations(robot), log.unmet_decisions,
                          settings.explain_limit);
  if (!log.unmet_decisions.empty()) json["unmet"] = unmet.json;
  if (has_body) {
    json["push_link"] = settings.push.link;
    json["push_body"] = log.floating.bodies[log.pushed.body].name;
    const Vec<double, 3> point = log.pushed.pose.translation();  // in the frame of the pushed body
    json["push_point"] = {point[0], point[1], point[2]};
    json["body"] = body_figures(log, log.floating);
    json["body"].update(to_json(*verdict.body));
  }

  context.output.write("config.yaml", std::string_view(context.effective_config));
  context.output.write("trajectory.csv", trajectory_table(log));
  context.output.write("ticks.csv", tick_table(log));
  if (!log.steps.empty()) context.output.write("steps.csv", step_table(log));
  if (!log.step_plans.empty()) context.output.write("plans.csv", plan_table(log));
  if (has_body) write_body(context.output, log, log.floating);
  context.output.write("summary.json", json);
  std::string not_drawn;
  if (settings.pictures && signal == 0) try {
      draw(context.output.path(), "pictures (they need matplotlib)", "plot_run");
      draw(context.output.path(), "report", "report");
    } catch (const InputError& error) {  // reported at the end, after all other output
      not_drawn = error.what();
    }

  fmt::print("{}\n", verdict.recovered ? "recovered" : "not recovered: " + verdict.reason);
  if (verdict.body && signal == 0)
    fmt::print("{}\n", verdict.body->is_hardware_safe()
                           ? "hardware-safe"
                           : "not hardware-safe: " + describe(verdict.body->excesses.front()));
  if (json.contains("step_plans") && json["step_plans"]["ticks_without_feasible_alternative"] > 0)
    fmt::print(
        "no plan met all limits in {} of {} planning ticks, first at {:.2f} s; the best of them "
        "was used\n",
        json["step_plans"]["ticks_without_feasible_alternative"].get<int>(), log.step_plans.size(),
        json["step_plans"]["first_without_s"].get<double>());
  fmt::print("{}", unmet.text);
  fmt::print("CoM height {:.3f} to {:.3f} m, |H| up to {:.2f} Nms, final CoM error {:.1f} mm\n",
             verdict.com_height_min, verdict.com_height_max, verdict.angular_momentum_max,
             1e3 * verdict.final_com_error);
  if (measured && json["body"]["estimate_com_error_m"].is_number())
    fmt::print("estimate: CoM error up to {:.1f} mm, velocity error {:.0f} mm/s rms\n",
               1e3 * json["body"]["estimate_com_error_m"].get<double>(),
               1e3 * json["body"]["estimate_velocity_error_m_s"].get<double>());
  if (log.mass_estimate)
    fmt::print("estimated mass {:.2f} kg, CoM of the model shifted by {:.1f}, {:.1f} mm\n",
               log.mass_estimate->mass, 1e3 * log.mass_estimate->com_shift[0],
               1e3 * log.mass_estimate->com_shift[1]);
  if (has_body && verdict.body->beyond_friction > 0.0)
    fmt::print(
        "the ground exerted {:.3f} N s of tangential impulse beyond the friction coefficient {}\n",
        verdict.body->beyond_friction, settings.plant.engine.friction);
  fmt::print("{}", settling_text(log, verdict, settling));
  fmt::print("{} solves by {}, median {:.3f} ms, {} failed, {} stopped by the deadline\n",
             log.ticks.size(), log.controller, 1e3 * log.statistics.all().median(),
             json["failures"].get<int>(), json["deadline_misses"].get<int>());
  if (has_body) {
    const double simulated = log.samples.back().time;
    fmt::print(
        "{}: per simulated second {:.3f} s planner, {:.3f} s whole-body control, {:.3f} s plant; "
        "{} "
        "of {} control steps not solved\n",
        log.plant, log.plan_seconds / simulated, log.control_seconds / simulated,
        log.plant_seconds / simulated, log.control_failures, log.control_calls);
  }
  fmt::print("{}", results_text(context.output.path(), context.output.begin()));
  if (signal != 0) {
    fmt::print("interrupted: results up to {:.2f} s\n", log.samples.back().time);
    std::fflush(nullptr);
    std::raise(signal);
  }
  if (!not_drawn.empty()) throw InputError(not_drawn);
  const bool failed =
      json["failures"].get<int>() > 0 || log.control_failed() || log.numerical_failure;
  return failed ? ExitStatus::solver_failed : ExitStatus::ok;
}

}  // namespace saltus::robots::walking
