// Whole problems drawn from a seed: phases, sizes, windows, terms, events, jumps, schedules, data,
// and in one of four a mistake. What must hold of all of them is in random_definitions_test.cpp.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "saltus/ocp/problem.hpp"

namespace saltus::test {

/// What a formula of a drawn problem throws, where that is the mistake.
struct FormulaIsOutOfOrder : std::runtime_error {
  FormulaIsOutOfOrder() : std::runtime_error("the formula is out of order") {}
};

struct RandomDefinition {
  OptimalControlProblem problem{"drawn"};
  /// Affine dynamics and rows, strictly convex costs, fixed durations, no events in phases: there
  /// is one optimum or none, and every solver has to say which.
  bool is_convex = true;
  std::string mistake;  ///< empty: none was made
};

/// The same for the same seed, on every machine. Throws what the definition throws.
RandomDefinition draw_definition(std::uint32_t seed);

}  // namespace saltus::test
