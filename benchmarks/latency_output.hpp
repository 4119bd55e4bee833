// Measured latencies as a table to read and as JSON to keep.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "benchmarks/latency.hpp"

namespace saltus::bench {

/// The head of the table and one line per case: they can be printed while the cases run.
std::string table_head();
std::string table_line(const CaseResult& result);
/// What is known at the end: times relative to the calibration kernel, comparisons, details and
/// every solve that failed.
std::string closing_text(const LatencyReport& report);

/// Machine, build, calibration_us, cases, comparisons.
nlohmann::ordered_json to_json(const LatencyReport& report);

}  // namespace saltus::bench
