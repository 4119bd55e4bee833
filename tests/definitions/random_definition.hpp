// Random problems from a seed: phases, sizes, windows, terms, events, jumps, schedules and data.
// One problem in four contains a mistake. random_definitions_test.cpp checks the properties that
// all of them must have.
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

#include "saltus/ocp/problem.hpp"

namespace saltus::test {

/// Exception of a formula whose mistake is to throw.
struct FormulaIsOutOfOrder : std::runtime_error {
  FormulaIsOutOfOrder() : std::runtime_error("the formula is out of order") {}
};

struct RandomDefinition {
  OptimalControlProblem problem{"drawn"};
  /// Affine dynamics and rows, strictly convex costs, fixed durations, no events in phases. There
  /// is one optimum or none, and every solver must report which.
  bool is_convex = true;
  std::string mistake;  ///< empty if the problem has no mistake
};

/// Returns the same problem for the same seed on every machine. Throws the exceptions of the
/// definition.
RandomDefinition draw_definition(std::uint32_t seed);

}  // namespace saltus::test
