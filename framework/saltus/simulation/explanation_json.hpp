// An explanation as data, for summaries and other programs.
#pragma once

#include <string>

#include "saltus/solve/explanation.hpp"

namespace saltus {

/// One object of JSON: "status", "relaxation", "missing" (a shortage each), "gives_way" (soft
/// terms, with their price), "gives_way_to", "cost", "remedies" (with their changes) and "seconds".
/// Times in s, amounts in units of the terms.
std::string explanation_json(const Explanation& explanation);

}  // namespace saltus
