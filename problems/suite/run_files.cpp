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

Json misses_json(const std::vector<PhasedPlant::Miss>& misses) {
  Json list = Json::array();
  for (const PhasedPlant::Miss& m : misses)
    list.push_back({{"phase", m.phase}, {"term", m.term}, {"t_s", m.time}, {"amount", m.amount}});
  return list;
}

Json misses_json(const std::vector<LoopMiss>& misses) {
  Json list = Json::array();
  for (const LoopMiss& m : misses)
    list.push_back({{"phase", m.phase},
                    {"term", m.term},
                    {"t_s", m.time},
                    {"amount", m.amount},
                    {"tolerance", m.tolerance},
                    {"at_end", m.at_end}});
  return list;
}

double largest(const std::vector<PhasedPlant::Miss>& misses) {
  double amount = 0.0;
  for (const PhasedPlant::Miss& m : misses) amount = std::max(amount, m.amount);
  return amount;
}

// The exact tick, not a bucket of the histogram.
const LoopLog::Tick* worst_tick(const LoopLog& log) {
  const auto worst = std::ranges::max_element(log.ticks, {}, &LoopLog::Tick::seconds);
  return worst == log.ticks.end() ? nullptr : &*worst;
}

constexpr Provenance all_provenances[] = {Provenance::optimal, Provenance::step,
                                          Provenance::feasible, Provenance::shifted,
                                          Provenance::fallback};

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
  for (const Solution::CostContribution& c : solution.costs)
    costs.push_back({{"phase", c.phase}, {"term", c.term}, {"value", c.value}});
  for (const HybridEvent& e : recording.events)
    events.push_back({{"t_s", e.time},
                      {"event", e.name},
                      {"kind", describe(e.kind)},
                      {"mode_before", e.mode_before},
                      {"mode_after", e.mode_after}});
  const Json described = Json::parse(summary_json("", solution));
  return {{"ok", solution.ok()},
          {"status", describe(solution.status)},
          {"cost", solution.cost},
          {"kkt_residual", solution.kkt.scaled()},
          {"iterations", solution.iterations},
          {"seconds", solution.seconds},
          {"method", solution.method},
          {"phases", phases},
          {"costs", costs},
          {"multipliers", described["multipliers"]},
          {"violations", described["violations"]},
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
  if (outcome.refinements > 0) text += "  " + outcome.refined_in_words() + "\n";
  if (outcome.verdict == Verdict::missed) text += "  " + outcome.reason_in_brief() + "\n";
  return text;
}

Json loop_json(const ReferenceCase& c, const Solution& plan, const LibraryLoop& loop,
               const PlanRunOut& planned) {
  const LoopLog& log = loop.log;
  Json provenance = Json::object(), events = Json::array(), worst = nullptr;
  for (const Provenance p : all_provenances) provenance[describe(p)] = log.count(p);
  for (const HybridEvent& e : log.recording.events)
    events.push_back({{"t_s", e.time},
                      {"event", e.name},
                      {"kind", describe(e.kind)},
                      {"mode_before", e.mode_before},
                      {"mode_after", e.mode_after}});
  if (const LoopLog::Tick* tick = worst_tick(log))
    worst = {{"t_s", tick->time},
             {"seconds", tick->seconds},
             {"provenance", tick->provenance ? describe(*tick->provenance) : ""},
             {"iterations", tick->iterations}};
  const auto quantiles = [](const LatencyHistogram& seconds) {
    return Json{{"median", seconds.median()}, {"p99", seconds.p99()}};
  };
  std::vector<double> end(log.final_state().begin(), log.final_state().end());
  return {{"id", c.id},
          {"name", c.name + " in closed loop"},
          {"summary", c.summary},
          {"source", c.source},
          {"kind", "closed loop"},
          {"completed", log.completed},
          {"ok", log.ok()},
          {"reached_end", log.reached_end},
          {"misses", misses_json(log.misses)},
          {"message", log.message},
          {"controller", log.controller},
          {"plant", log.plant},
          {"horizon", describe(loop.horizon)},
          {"period_s", log.period},
          {"start_s", log.recording.samples.front().time},
          {"end_s", loop.over_since.value_or(log.recording.samples.back().time)},
          {"ticks", log.ticks.size()},
          {"provenance", provenance},
          {"fallbacks", log.count(Provenance::fallback)},
          {"solve_s", quantiles(log.statistics.all())},
          {"check_s", quantiles(log.statistics.check)},
          {"worst_tick", worst},
          {"cost", loop.cost},
          {"cost_of_plan", planned.cost},
          {"cost_of_plan_by_solver", plan.cost},
          {"plan_end_s", plan.trajectory.end_time()},
          {"missed_at_ends", misses_json(loop.end_misses)},
          {"missed_on_the_way", misses_json(loop.path_misses)},
          {"plan_missed_at_ends", misses_json(planned.end_misses)},
          {"final_state", end},
          {"events", events},
          {"states", log.recording.state_columns()},
          {"inputs", log.recording.input_columns()},
          {"tables", {"trajectory.csv"}},
          {"versions", versions()}};
}

std::string loop_text(const ReferenceCase& c, const LibraryLoop& loop, const PlanRunOut& planned) {
  std::string counts;
  for (const Provenance p : all_provenances)
    if (const int n = loop.log.count(p); n > 0)
      counts += fmt::format("{}{} {}", counts.empty() ? "" : ", ", n, describe(p));
  const LoopLog::Tick* worst = worst_tick(loop.log);
  return fmt::format(
      "{} {} in closed loop, horizon {}: {}\n"
      "  {} ticks ({}), the slowest {:.3g} ms\n"
      "  cost {:.6g} (the first plan in the same plant: {:.6g}); terminal violation {:.2g}, path "
      "violation {:.2g}\n",
      c.id, c.name, describe(loop.horizon), loop.log.message, loop.log.ticks.size(), counts,
      worst == nullptr ? 0.0 : 1e3 * worst->seconds, loop.cost, planned.cost,
      largest(loop.end_misses), largest(loop.path_misses));
}

}  // namespace saltus
