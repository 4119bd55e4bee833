// Problems for the laws: every case of the library, every example, every step of the tutorial.
#pragma once

#include <string>
#include <vector>

#include "tests/metamorphic/laws.hpp"

namespace saltus::metamorphic {

struct Case {
  std::string name;
  std::function<Stated()> stated;
  int max_iterations = 500;
  bool is_quick = false;  ///< all solvers together take less than about 0.1 s
};
const std::vector<Case>& cases();

/// The problems of examples/ and docs/, which their programs do not export.
std::vector<Case> program_cases();

}  // namespace saltus::metamorphic
