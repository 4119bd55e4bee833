// Writes solutions as JSON and CSV tables in the format of `saltus view`.
#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <map>
#include <utility>

#include "saltus/core/csv_table.hpp"
#include "saltus/core/json_object.hpp"
#include "saltus/simulation/loop_log.hpp"

namespace saltus {
namespace {

bool has_several_phases(const Solution& plan) { return plan.trajectory.phases().size() > 1; }

// "ceiling", or "climb: ceiling 1" with several phases and rows.
std::string column_of(const Solution& plan, const Solution::Multiplier& multiplier) {
  bool has_rows = false;
  for (const Solution::Multiplier& other : plan.multipliers)
    has_rows = has_rows ||
               (other.row > 0 && other.term == multiplier.term && other.phase == multiplier.phase);
  const std::string name =
      has_rows ? fmt::format("{} {}", multiplier.term, multiplier.row) : multiplier.term;
  return has_several_phases(plan) && !multiplier.phase.empty()
             ? fmt::format("{}: {}", multiplier.phase, name)
             : name;
}

std::string json_of(const Solution::Multiplier& multiplier) {
  double lower = 0.0, upper = 0.0, largest = 0.0, time = 0.0;
  for (std::size_t i = 0; i < multiplier.values.size(); ++i) {
    const double value = multiplier.values[i];
    (value > 0.0 ? lower : upper) += value;
    if (!(std::abs(value) > largest)) continue;
    largest = std::abs(value);
    time = multiplier.times[i];
  }
  return JsonObject()
      .text("phase", multiplier.phase)
      .text("term", multiplier.term)
      .integer("row", multiplier.row)
      .number("lower", lower)
      .number("upper", upper)
      .number("t_s", time)
      .str();
}

std::string json_of(const Verification::Miss& miss, const char* kind) {
  return JsonObject()
      .text("kind", kind)
      .text("phase", miss.phase)
      .text("term", miss.term)
      .number("t_s", miss.time)
      .number("amount", miss.amount)
      .number("tolerance", miss.tolerance)
      .str();
}

}  // namespace

std::string multipliers_csv(const Solution& plan) {
  std::vector<std::string> columns{"t [s]"};
  // A column may have several values at one time. Rows are ordered by time, then by their index.
  std::map<std::pair<double, int>, std::vector<double>> rows;
  std::vector<const Solution::Multiplier*> curves;
  for (const Solution::Multiplier& multiplier : plan.multipliers)
    if (multiplier.times.size() > 1) curves.push_back(&multiplier);
  const std::size_t count = curves.size();
  for (std::size_t column = 0; column < count; ++column) {
    const Solution::Multiplier& multiplier = *curves[column];
    columns.push_back(column_of(plan, multiplier));
    std::map<double, int> seen;
    for (std::size_t i = 0; i < multiplier.values.size(); ++i) {
      const double t = multiplier.times[i];
      std::vector<double>& row = rows[{t, seen[t]++}];
      row.resize(count, std::numeric_limits<double>::quiet_NaN());
      row[column] = multiplier.values[i];
    }
  }
  CsvTable table(columns);
  for (const auto& [instant, row] : rows) {
    table.number(instant.first);
    for (const double value : row) std::isnan(value) ? table.empty() : table.number(value);
    table.end_row();
  }
  return table.text();
}

std::string summary_json(const std::string& name, const Solution& plan) {
  std::vector<Solution::Multiplier> constraints;
  for (const Solution::Multiplier& multiplier : plan.multipliers)
    if (multiplier.term != Solution::Multiplier::costate) constraints.push_back(multiplier);
  std::vector<std::string> violations;
  if (plan.verification)
    for (const auto& [miss, kind] :
         {std::pair{&plan.verification->at_nodes, "at the nodes"},
          std::pair{&plan.verification->between_nodes, "between the nodes"}})
      if (miss->amount > 0.0) violations.push_back(json_of(*miss, kind));
  for (const Solution::SoftViolation& soft : plan.soft_violations)
    violations.push_back(JsonObject()
                             .text("kind", "soft")
                             .text("phase", soft.phase)
                             .text("term", soft.term)
                             .number("t_s", soft.time)
                             .number("amount", soft.largest)
                             .str());
  const auto cost = [](const Solution::CostContribution& c) {
    return JsonObject().text("phase", c.phase).text("term", c.term).number("value", c.value).str();
  };
  const auto multiplier = [](const Solution::Multiplier& m) { return json_of(m); };
  const auto raw = [](const std::string& json) { return json; };
  return JsonObject()
      .text("name", name)
      .flag("ok", plan.ok())
      .text("status", describe(plan.status))
      .text("message", plan.message)
      .number("cost", plan.cost)
      .integer("iterations", plan.iterations)
      .number("seconds", plan.seconds)
      .text("method", plan.method)
      .raw("durations_s", json_list(plan.durations, json_number))
      .raw("costs", json_list(plan.costs, cost))
      .raw("multipliers", json_list(constraints, multiplier))
      .raw("violations", json_list(violations, raw))
      .lines();
}

}  // namespace saltus
