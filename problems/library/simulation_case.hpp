// A simulation or closed form with known answers: what runs and what has to come out.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "problems/library/checked_value.hpp"

namespace saltus {

struct SimulationCase {
  std::string id;         ///< short and stable, as in the literature list: "D01"
  std::string name;       ///< of the file in problems/library: "van_der_pol_stiff"
  std::string exercises;  ///< what of the framework it puts to the test
  std::string source;     ///< where the statement and the answers come from
  /// Everything that is known, each with its own tolerance. What could not be computed is NaN.
  std::function<std::vector<CheckedValue>()> run;
};

}  // namespace saltus
