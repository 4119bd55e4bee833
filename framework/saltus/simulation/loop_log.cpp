#include "saltus/simulation/loop_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <span>

#include "saltus/core/csv_table.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/json_object.hpp"
#include "saltus/core/temporary_file.hpp"

namespace saltus {
namespace {

std::string quantiles(const LatencyHistogram& latency) {
  if (latency.count() == 0) return "null";
  return JsonObject()
      .number("median", latency.median())
      .number("p99", latency.p99())
      .number("max", latency.max())
      .str();
}

}  // namespace

const VectorXd& LoopLog::final_state() const {
  if (recording.samples.empty())
    throw DefinitionError("loop log: it has no samples, so there is no final state");
  return recording.samples.back().state;
}

int LoopLog::count(Provenance provenance) const {
  return static_cast<int>(std::count_if(ticks.begin(), ticks.end(), [&](const LoopLog::Tick& tick) {
    return tick.provenance == provenance;
  }));
}

std::string LoopLog::ticks_csv() const {
  std::vector<std::string> columns{"t [s]",      "provenance",     "status",
                                   "iterations", "objective",      "KKT residual",
                                   "violation",  "solve time [s]", "check time [s]"};
  for (const std::string& state : recording.state_columns()) columns.push_back("measured " + state);
  CsvTable table(columns);
  for (const LoopLog::Tick& tick : ticks) {
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
  const auto span_of = [](const VectorXd& v) {
    return std::span(v.data(), static_cast<std::size_t>(v.size()));
  };
  CsvTable table(columns);
  for (const LoopLog::Plan& plan : plans)
    for (const Sample& s : plan.samples) {
      table.number(plan.made_at).number(s.time).word(s.mode);
      table.numbers(span_of(s.state), states.size()).numbers(span_of(s.input), inputs.size());
      table.end_row();
    }
  return table.text();
}

std::string LoopLog::summary_json() const {
  const std::vector<Sample>& samples = recording.samples;
  JsonObject counts;
  for (const Provenance p : {Provenance::optimal, Provenance::step, Provenance::feasible,
                             Provenance::shifted, Provenance::fallback})
    counts.integer(describe(p), count(p));
  const auto missed = [](const LoopMiss& m) {
    return JsonObject()
        .text("phase", m.phase)
        .text("term", m.term)
        .number("t_s", m.time)
        .number("amount", m.amount)
        .number("tolerance", m.tolerance)
        .flag("at_end", m.at_end)
        .str();
  };
  const auto happened = [](const HybridEvent& e) {
    return JsonObject()
        .number("t_s", e.time)
        .text("event", e.name)
        .text("kind", describe(e.kind))
        .text("mode_after", e.mode_after)
        .str();
  };
  const auto word = [](const std::string& text) { return json_string(text); };
  return JsonObject()
      .flag("completed", completed)
      .flag("ok", ok())
      .flag("reached_end", reached_end)
      .text("message", message)
      .raw("misses", json_list(misses, missed))
      .text("controller", controller)
      .text("plant", plant)
      .raw("states", json_list(recording.state_columns(), word))
      .raw("inputs", json_list(recording.input_columns(), word))
      .number("period_s", period)
      .integer("ticks", static_cast<long>(ticks.size()))
      .number("start_s", samples.empty() ? infinity : samples.front().time)
      .number("end_s", samples.empty() ? infinity : samples.back().time)
      .raw("provenance", counts.str())
      .raw("solve_s", quantiles(statistics.all()))
      .raw("check_s", quantiles(statistics.check))
      .raw("events", json_list(recording.events, happened))
      .raw("final_state", json_list(samples.empty() ? VectorXd() : final_state(), json_number))
      .lines();
}

void LoopLog::write(const std::string& path) const {
  recording.write(path);
  const std::filesystem::path folder(path);
  write_atomically(folder / "ticks.csv", ticks_csv());
  if (!plans.empty()) write_atomically(folder / "plans.csv", plans_csv());
  write_atomically(folder / "summary.json", summary_json());
}

}  // namespace saltus
