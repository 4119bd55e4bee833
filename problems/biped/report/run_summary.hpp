// Summary and tables of a run, for all plants.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "saltus/core/csv_table.hpp"
#include "saltus/robots/walking/biped_problem.hpp"
#include "saltus/robots/walking/biped_settings.hpp"

namespace saltus::robots::walking {

/// Median, p99, p999 and maximum, us.
nlohmann::ordered_json latency(const LatencyHistogram& times);

/// Contents of summary.json: verdict, quantities, changed settings and statistics of the planner.
nlohmann::ordered_json summary(const BipedSettings& settings, const RunLog& log,
                               const Verdict& verdict);

/// trajectory.csv: a row per sample (s, m, m/s, Nms, N, Nm). The push is the mean until the next
/// sample.
CsvTable trajectory_table(const RunLog& log);
/// steps.csv: a row per step (s, m).
CsvTable step_table(const RunLog& log);
/// plans.csv: a row per tick in which steps are planned or compared, with the first step of the
/// plan, the number of the chosen alternative (from 1 on), and all alternatives with their costs.
CsvTable plan_table(const RunLog& log);
/// ticks.csv: a row per tick of the planner.
CsvTable tick_table(const RunLog& log);

/// The settings that differ from their defaults: key, value, default, unit. Both texts list the
/// same keys in the same order, each line "key: value  # unit" or, of a section, "key:"; two spaces
/// per level.
nlohmann::ordered_json changed_settings(const std::string& effective_config,
                                        const std::string& default_config);

}  // namespace saltus::robots::walking
