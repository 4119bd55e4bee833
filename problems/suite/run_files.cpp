#include "problems/suite/run_files.hpp"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <nlohmann/json.hpp>

namespace saltus {
namespace {

using Json = nlohmann::ordered_json;

Json versions() {
  return {{"saltus", SALTUS_VERSION},
          {"eigen",
           fmt::format("{}.{}.{}", EIGEN_WORLD_VERSION, EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION)},
          {"compiler", __VERSION__},
          {"build_type", SALTUS_BUILD_TYPE}};
}

std::string suffix_of(const std::string& name) { return name.empty() ? "" : "_" + name; }

}  // namespace

void write_recording(const OutputFolder& output, const Recording& recording,
                     const std::string& name) {
  const std::string trajectory = recording.trajectory_csv(), events = recording.events_csv();
  output.write("trajectory" + suffix_of(name) + ".csv", std::string_view(trajectory));
  output.write("events" + suffix_of(name) + ".csv", std::string_view(events));
}

Json summary_head(const CaseOutcome& outcome, const std::string& summary) {
  return {{"id", outcome.id},
          {"name", outcome.name},
          {"summary", summary},
          {"exercises", outcome.exercises},
          {"source", outcome.source},
          {"kind", outcome.is_simulation ? "simulation" : "optimal control"},
          {"verdict", word_for(outcome.verdict)},
          {"message", outcome.status},
          {"versions", versions()}};
}

Json checked_json(const CaseOutcome& outcome) {
  Json list = Json::array();
  for (const CheckedValue& v : outcome.checked)
    list.push_back({{"name", v.name},
                    {"value", v.value},
                    {"reference", v.reference},
                    {"error", v.error()},
                    {"tolerance", v.tolerance},
                    {"met", v.is_met()}});
  return list;
}

Json solution_json(const Solution& solution, const Recording& recording) {
  Json phases = Json::array(), costs = Json::array(), events = Json::array();
  for (std::size_t j = 0; j < solution.durations.size(); ++j)
    phases.push_back(
        {{"name", solution.trajectory.phases()[j].name}, {"duration_s", solution.durations[j]}});
  for (const CostContribution& c : solution.costs)
    costs.push_back({{"phase", c.phase}, {"term", c.term}, {"value", c.value}});
  for (const HybridEvent& e : recording.events)
    events.push_back({{"t_s", e.time},
                      {"event", e.name},
                      {"kind", describe(e.kind)},
                      {"mode_before", e.mode_before},
                      {"mode_after", e.mode_after}});
  return {{"ok", solution.ok()},
          {"status", describe(solution.status)},
          {"cost", solution.cost},
          {"kkt_residual", solution.kkt.scaled()},
          {"iterations", solution.iterations},
          {"seconds", solution.seconds},
          {"method", solution.method},
          {"phases", phases},
          {"costs", costs},
          {"events", events}};
}

std::string verdict_text(const CaseOutcome& outcome) {
  std::string text = outcome.status + "\n";
  if (!outcome.checked.empty()) {
    const CheckedValue& v = outcome.checked.front();
    const int digits = v.digits > 0 ? std::min(v.digits, 15) : 6;
    text += fmt::format("  {} {:.{}g}, reference {:.{}g}", v.name, v.value, digits, v.reference,
                        digits);
    if (v.digits > 0) text += fmt::format(" ({} of {} digits)", v.digits_reached(), v.digits);
    text += "\n";
  }
  if (outcome.verdict == Verdict::missed) text += "  " + outcome.reason_in_brief() + "\n";
  return text;
}

}  // namespace saltus
