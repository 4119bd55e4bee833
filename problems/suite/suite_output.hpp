// What the suite found as a table to read and as JSON to keep.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "problems/suite/suite.hpp"

namespace saltus {

/// The head of the table and one line per case: they can be printed while the cases run. The error
/// is relative to the reference; "digits" is how many agree of how many are known; "between" is the
/// largest violation of a path constraint between the nodes.
std::string table_head();
std::string table_line(const CaseOutcome& outcome);
/// Why cases miss their tolerances, a sentence each, and how many do not.
std::string closing_text(const SuiteReport& report);

/// Everything at full precision, with all checked values.
nlohmann::ordered_json to_json(const SuiteReport& report);

}  // namespace saltus
