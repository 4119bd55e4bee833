// What planners could not keep to in a run, explained: when it is over.
#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "saltus/robots/walking/unmet_words.hpp"

namespace saltus::walking {

/// Unmet decisions in words and as data.
struct UnmetReport {
  nlohmann::ordered_json json;  ///< a list: decision, time, by how much, and the explanation
  std::string text;             ///< some lines per decision, empty if there is none
};

/// Explains every decision, within so many seconds each (0: none is explained).
UnmetReport explain_unmet(const UnmetWords& words, const std::vector<UnmetDecision>& unmet,
                          double time_limit);

}  // namespace saltus::walking
