// Explanations as JSON, for summaries and other programs.
#pragma once

#include <string>

#include "saltus/solve/explain.hpp"

namespace saltus {

/// Returns a JSON object: "status", "relaxation", "missing" (shortages), "gives_way" (soft terms
/// with their price), "gives_way_to", "cost", "remedies" (with their changes) and "seconds". Times
/// are in seconds, amounts in units of the terms.
std::string explanation_json(const Explanation& explanation);

}  // namespace saltus
