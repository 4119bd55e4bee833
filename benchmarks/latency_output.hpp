// Measured latencies as a table and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "benchmarks/latency.hpp"

namespace saltus::bench {

/// The head of the table and one line per case, which can be printed while the cases run.
std::string table_head();
std::string table_line(const CaseResult& result);
/// The closing text: times relative to the calibration kernel, comparisons, details and every
/// failed solve.
std::string closing_text(const LatencyReport& report);

/// Machine, build, calibration_us, cases, comparisons.
nlohmann::ordered_json to_json(const LatencyReport& report);

}  // namespace saltus::bench
