#include "problems/quadruped/quadruped.hpp"

#include <fmt/format.h>

#include <csignal>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "problems/quadruped/run.hpp"
#include "saltus/app/defer_signals.hpp"
#include "saltus/app/python_script.hpp"
#include "saltus/core/csv_table.hpp"

namespace saltus::quadruped {
namespace {

using Json = nlohmann::ordered_json;

// Counts of the provenances: "1980 optimal, 20 step".
std::string provenances_in_words(const LoopLog& log) {
  std::string text;
  for (const Provenance p : {Provenance::optimal, Provenance::step, Provenance::feasible,
                             Provenance::shifted, Provenance::fallback})
    if (const int n = log.count(p); n > 0)
      text += fmt::format("{}{} {}", text.empty() ? "" : ", ", n, describe(p));
  return text;
}

std::string outcome_in_words(const RunLog& run) {
  return run.fell ? fmt::format("fell at {:.2f} s", run.rows.back().time) : "recovered";
}

CsvTable feet_table(const RunLog& run) {
  std::vector<std::string> columns{"t [s]", "tilt [rad]", "height [m]"};
  for (const char* leg : leg_names) {
    for (const char axis : {'x', 'y', 'z'}) columns.push_back(fmt::format("{} {} [m]", leg, axis));
    columns.push_back(fmt::format("{} force [N]", leg));
    columns.push_back(fmt::format("{} touches", leg));
    columns.push_back(fmt::format("{} planned", leg));
  }
  CsvTable table(columns);
  for (const Row& r : run.rows) {
    std::vector<double> row{r.time, r.tilt, r.height};
    for (int leg = 0; leg < legs; ++leg)
      row.insert(row.end(), {r.feet(0, leg), r.feet(1, leg), r.feet(2, leg),
                             r.touching[leg] ? r.forces(2, leg) : 0.0, r.touching[leg] ? 1.0 : 0.0,
                             r.planned[leg] ? 1.0 : 0.0});
    table.add_row(row);
  }
  return table;
}

Json summary_of(const Config& config, const RunLog& run) {
  const LatencyHistogram ticks = run.log.statistics.all();
  Json provenance = Json::object();
  for (const Provenance p : {Provenance::optimal, Provenance::step, Provenance::feasible,
                             Provenance::shifted, Provenance::fallback})
    provenance[describe(p)] = run.log.count(p);
  const VectorXd& end = run.log.final_state();
  return {{"name", "quadruped"},
          {"kind", "closed loop"},
          {"gait", config.gait},
          {"blind", config.controller.gait.blind},
          {"recovered", !run.fell && DeferSignals::received() == 0},
          {"interrupted", DeferSignals::received() != 0},
          {"message", run.message()},
          {"controller", run.log.controller},
          {"plant", run.log.plant},
          {"period_s", run.log.period},
          {"end_s", run.log.recording.samples.back().time},
          {"ticks", run.log.ticks.size()},
          {"provenance", provenance},
          {"solve_s", {{"median", ticks.median()}, {"p99", ticks.p99()}, {"largest", ticks.max()}}},
          {"early_landings", run.early},
          {"late_landings", run.late},
          {"gait_waited_s", run.waited},
          {"push_start_s", config.push.start},
          {"largest_tilt_rad", run.farthest},
          {"final_state", std::vector<double>(end.begin(), end.end())},
          {"states", run.log.recording.state_columns()},
          {"inputs", run.log.recording.input_columns()},
          {"tables", {"trajectory.csv"}}};
}

ExitStatus run_campaign(const Config& config, const RunContext& context) {
  CsvTable table({"seed", "push towards [deg]", "push start [s]", "seeing recovered",
                  "blind recovered", "seeing largest tilt [rad]", "blind largest tilt [rad]",
                  "early landings", "late landings", "seeing end [s]", "blind end [s]",
                  "tick p99 [s]"});
  int recovered[2] = {0, 0};
  LatencyHistogram ticks;
  for (int i = 0; i < config.runs; ++i) {
    const Config one = disturbed(config, i, false);
    const RunLog seeing = run(one), blind = run(disturbed(config, i, true));
    if (DeferSignals::received() != 0) break;  // these two runs are incomplete
    recovered[0] += seeing.fell ? 0 : 1;
    recovered[1] += blind.fell ? 0 : 1;
    ticks.merge(seeing.log.statistics.all());
    table.add_row(std::vector<double>{1.0 * one.seed, one.towards, one.push.start,
                                      seeing.fell ? 0.0 : 1.0, blind.fell ? 0.0 : 1.0,
                                      seeing.farthest, blind.farthest, 1.0 * seeing.early,
                                      1.0 * seeing.late, seeing.rows.back().time,
                                      blind.rows.back().time, seeing.log.statistics.all().p99()});
    fmt::print("{} of {}: {}; blind: {}\n", i + 1, config.runs, outcome_in_words(seeing),
               outcome_in_words(blind));
    std::fflush(stdout);
  }
  context.output.write("config.yaml", std::string_view(context.effective_config));
  context.output.write("campaign.csv", table);
  context.output.write("summary.json", Json{{"name", "quadruped"},
                                            {"kind", "campaign"},
                                            {"size", config.scale},
                                            {"roughness_m", config.scale * config.roughness},
                                            {"impulse_N_s", config.scale * config.push.impulse},
                                            {"runs", table.rows()},
                                            {"recovered", recovered[0]},
                                            {"recovered_blind", recovered[1]},
                                            {"tick_p99_s", ticks.p99()}});
  if (config.pictures && DeferSignals::received() == 0)
    run_python_module("saltus.plot_quadruped", context.output.path(), "picture");
  fmt::print(
      "size {}: ground within {:.1f} cm, push of {:.1f} N s, {} runs of {} s\n"
      "recovered: {} of {}; without contact sensing: {} of {}\n"
      "a tick takes {:.2f} ms in the median, {:.2f} ms at p99; the period is {:.0f} ms\n"
      "results in {}: campaign.csv, summary.json\n",
      config.scale, 100.0 * config.scale * config.roughness, config.scale * config.push.impulse,
      table.rows(), config.duration, recovered[0], table.rows(), recovered[1], table.rows(),
      1e3 * ticks.median(), 1e3 * ticks.p99(), 1e3 * config.controller.period,
      context.output.path().string());
  return ExitStatus::ok;
}

ExitStatus run_quadruped(const Config& config, const RunContext& context) {
  if (config.runs > 0) return run_campaign(config, context);
  const RunLog result = run(config);
  const OutputFolder& output = context.output;
  output.write("config.yaml", std::string_view(context.effective_config));
  output.write("trajectory.csv", std::string_view(result.log.recording.trajectory_csv()));
  output.write("events.csv", std::string_view(result.log.recording.events_csv()));
  output.write("ticks.csv", std::string_view(result.log.ticks_csv()));
  output.write("feet.csv", feet_table(result));
  output.write("summary.json", summary_of(config, result));
  const bool drawn = config.pictures && DeferSignals::received() == 0 &&
                     run_python_module("saltus.plot_quadruped", output.path(), "picture");
  const LatencyHistogram ticks = result.log.statistics.all();
  const VectorXd& end = result.log.final_state();
  const char* verdict = DeferSignals::received() != 0 ? "interrupted"
                        : result.fell                 ? "fell"
                                                      : "recovered";
  fmt::print(
      "{}: {}\n"
      "reached ({:.2f}, {:.2f}) m in {:.2f} s; largest tilt {:.1f} degrees\n"
      "{} early landings, {} late ones; the gait waited {:.2f} s in total\n"
      "{} ticks ({}); a tick takes {:.2f} ms in the median, {:.2f} ms at p99; the period is {:.0f} "
      "ms\n"
      "results in {}: trajectory, events, ticks and feet (.csv), summary.json{}\n",
      verdict, result.message(), end[0], end[1], result.log.recording.samples.back().time,
      57.29578 * result.farthest, result.early, result.late, result.waited, result.log.ticks.size(),
      provenances_in_words(result.log), 1e3 * ticks.median(), 1e3 * ticks.p99(),
      1e3 * config.controller.period, output.path().string(), drawn ? ", picture (.png)" : "");
  return result.log.completed ? ExitStatus::ok : ExitStatus::solver_failed;
}

// An interrupt ends the run and keeps its results.
ExitStatus run_to_the_end_or_interrupt(const Config& config, const RunContext& context) {
  ExitStatus status = ExitStatus::ok;
  int signal = 0;
  {
    const DeferSignals note;
    status = run_quadruped(config, context);
    signal = DeferSignals::received();
  }
  if (signal != 0) {
    fmt::print("interrupted: results so far\n");
    std::fflush(nullptr);
    std::raise(signal);
  }
  return status;
}

}  // namespace

ProblemEntry entry() {
  return problem_entry<Config>(
      "quadruped",
      "a quadruped trots over uneven ground, which it assumes to be level, and is pushed",
      declare_settings, run_to_the_end_or_interrupt);
}

}  // namespace saltus::quadruped
