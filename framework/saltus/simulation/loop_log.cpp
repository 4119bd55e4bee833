#include "saltus/simulation/loop_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>

#include "saltus/core/error.hpp"
#include "saltus/simulation/text_table.hpp"

namespace saltus {
namespace {

void write_file(const std::filesystem::path& file, const std::string& text) {
  std::ofstream stream(file, std::ios::binary | std::ios::trunc);
  stream << text;
  stream.close();
  if (!stream) throw InputError(fmt::format("cannot write '{}'", file.string()));
}

std::string json_list(const std::vector<std::string>& words) {
  std::string list;
  for (const std::string& word : words) list += (list.empty() ? "" : ", ") + json_string(word);
  return "[" + list + "]";
}

std::string quantiles(const LatencyHistogram& latency) {
  if (latency.count() == 0) return "null";
  return fmt::format(R"({{"median": {}, "p99": {}, "max": {}}})", json_number(latency.median()),
                     json_number(latency.p99()), json_number(latency.max()));
}

}  // namespace

const VectorXd& LoopLog::final_state() const {
  if (recording.samples.empty())
    throw DefinitionError("loop log: it has no sample, so that there is no final state");
  return recording.samples.back().state;
}

int LoopLog::count(Provenance provenance) const {
  return static_cast<int>(std::count_if(ticks.begin(), ticks.end(), [&](const LoopTick& tick) {
    return tick.provenance == provenance;
  }));
}

std::string LoopLog::ticks_csv() const {
  std::vector<std::string> columns{"t [s]",      "provenance",     "status",
                                   "iterations", "objective",      "KKT residual",
                                   "violation",  "solve time [s]", "check time [s]"};
  for (const std::string& state : recording.state_columns()) columns.push_back("measured " + state);
  TextTable table(columns);
  for (const LoopTick& tick : ticks) {
    table.number(tick.time);
    if (tick.provenance) {
      table.word(describe(*tick.provenance)).word(describe(tick.status)).integer(tick.iterations);
      for (const double x : {tick.objective, tick.kkt, tick.violation})
        std::isfinite(x) ? table.number(x) : table.empty();
    } else {
      table.word("feedback law");
      for (int i = 0; i < 5; ++i) table.empty();
    }
    table.number(tick.seconds).number(tick.check);
    for (const double x : tick.measured) table.number(x);
    table.end_row();
  }
  return table.text();
}

std::string LoopLog::plans_csv() const {
  const std::vector<std::string> states = recording.state_columns();
  const std::vector<std::string> inputs = recording.input_columns();
  std::vector<std::string> columns{"made at [s]", "t [s]", "mode"};
  columns.insert(columns.end(), states.begin(), states.end());
  columns.insert(columns.end(), inputs.begin(), inputs.end());
  const auto nx = static_cast<Eigen::Index>(states.size());
  const auto nu = static_cast<Eigen::Index>(inputs.size());
  TextTable table(columns);
  for (const LoopPlan& plan : plans)
    for (const Sample& s : plan.samples) {
      table.number(plan.made_at).number(s.time).word(s.mode);
      for (Eigen::Index i = 0; i < nx; ++i)
        i < s.state.size() ? table.number(s.state[i]) : table.empty();
      for (Eigen::Index i = 0; i < std::min(nu, s.input.size()); ++i) table.number(s.input[i]);
      table.end_row();
    }
  return table.text();
}

std::string LoopLog::summary_json() const {
  const std::vector<Sample>& samples = recording.samples;
  std::string text = "{\n";
  const auto add = [&text](const char* key, const std::string& value) {
    text += fmt::format("{}  \"{}\": {}", text.size() > 2 ? ",\n" : "", key, value);
  };
  add("completed", completed ? "true" : "false");
  add("ok", ok() ? "true" : "false");
  add("reached_end", reached_end ? "true" : "false");
  add("message", json_string(message));
  std::string missed;
  for (const LoopMiss& m : misses)
    missed += fmt::format(
        R"({}    {{"phase": {}, "term": {}, "t_s": {}, "amount": {}, "tolerance": {}, "at_end": {}}})",
        missed.empty() ? "\n" : ",\n", json_string(m.phase), json_string(m.term),
        json_number(m.time), json_number(m.amount), json_number(m.tolerance), m.at_end);
  add("misses", "[" + missed + (missed.empty() ? "]" : "\n  ]"));
  add("controller", json_string(controller));
  add("plant", json_string(plant));
  add("states", json_list(recording.state_columns()));
  add("inputs", json_list(recording.input_columns()));
  add("period_s", json_number(period));
  add("ticks", fmt::format("{}", ticks.size()));
  add("start_s", samples.empty() ? "null" : json_number(samples.front().time));
  add("end_s", samples.empty() ? "null" : json_number(samples.back().time));
  std::string counts;
  for (const Provenance p : {Provenance::optimal, Provenance::step, Provenance::feasible,
                             Provenance::shifted, Provenance::fallback})
    counts += fmt::format("{}\"{}\": {}", counts.empty() ? "" : ", ", describe(p), count(p));
  add("provenance", "{" + counts + "}");
  add("solve_s", quantiles(statistics.all()));
  add("check_s", quantiles(statistics.check));
  std::string list;
  for (const HybridEvent& e : recording.events)
    list += fmt::format(R"({}    {{"t_s": {}, "event": {}, "kind": "{}", "mode_after": {}}})",
                        list.empty() ? "\n" : ",\n", json_number(e.time), json_string(e.name),
                        describe(e.kind), json_string(e.mode_after));
  add("events", "[" + list + (list.empty() ? "]" : "\n  ]"));
  std::string end;
  if (!samples.empty())
    for (int i = 0; i < final_state().size(); ++i)
      end += (i > 0 ? ", " : "") + json_number(final_state()[i]);
  add("final_state", "[" + end + "]");
  return text + "\n}\n";
}

void LoopLog::write(const std::string& path) const {
  const std::filesystem::path folder(path);
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  write_file(folder / "trajectory.csv", recording.trajectory_csv());
  write_file(folder / "events.csv", recording.events_csv());
  write_file(folder / "ticks.csv", ticks_csv());
  if (!plans.empty()) write_file(folder / "plans.csv", plans_csv());
  write_file(folder / "summary.json", summary_json());
}

}  // namespace saltus
