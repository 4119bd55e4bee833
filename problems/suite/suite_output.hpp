// The results of the suite as a table and as JSON.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "problems/suite/suite.hpp"

namespace saltus {

/// The head of the table and one line per case, which can be printed while the cases run. The error
/// is relative to the reference. "digits" is the number of correct digits of the known ones.
/// "between" is the largest violation of a path constraint between the nodes.
std::string table_head();
std::string table_line(const CaseOutcome& outcome);
/// One sentence per case outside its tolerance, and the number of cases within.
std::string closing_text(const SuiteReport& report);

/// All results at full precision, with all checked values.
nlohmann::ordered_json to_json(const SuiteReport& report);

}  // namespace saltus
