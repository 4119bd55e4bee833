// Explanations, after a run, of constraints that planners could not satisfy.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "saltus/robots/walking/biped_problem.hpp"

namespace saltus::robots::walking {

/// Unmet decisions as text and as data.
struct UnmetReport {
  nlohmann::ordered_json json;  ///< a list: decision, time, violation, and explanation
  std::string text;             ///< a few lines per decision; empty if there are none
};

/// Explains every decision, each within a time limit in s (0: explains none).
UnmetReport explain_unmet(const UnmetExplanations& words, const std::vector<UnmetDecision>& unmet,
                          double time_limit);

}  // namespace saltus::robots::walking
