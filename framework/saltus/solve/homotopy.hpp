// A hard problem by way of easy ones: a parameter moves from where the problem is easily solved to
// where it is wanted, and every solution is the start of the next.
//
//     MultipleShooting shooting(swing_up, options);
//     const Homotopy way = solve_along(shooting, *solver, "gravity", no_gravity, earth);
//     if (way.ok()) way.solution.cost;
#pragma once

#include <string_view>
#include <vector>

#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// How a parameter is led from an easy value to the one that is wanted.
struct HomotopyOptions {
  double first_step =
      0.25;  ///< of the way, 0 to 1; doubled after a success, halved after a failure
  double least_step = 1e-3;  ///< below it the way ends
};

/// What a homotopy gave.
struct Homotopy {
  Solution solution;     ///< at `reached`; where not even the first solve worked, that one
  double reached = 0.0;  ///< part of the way; 1: all of it
  /// One solve on the way.
  struct Step {
    double at = 0.0;      ///< part of the way
    double cost = 0.0;    ///< of it
    bool solved = false;  ///< with success
    int iterations = 0;   ///< of it
  };
  std::vector<Step> steps;  ///< in the order in which they were tried

  /// Whether the wanted problem was solved.
  bool ok() const { return reached == 1.0 && solution.ok(); }
};

/// Data `name` of the problem from one value to another, on the straight line between them. The
/// shooting keeps the value of the last solve that worked. Throws DefinitionError for names and
/// sizes that are wrong.
Homotopy solve_along(MultipleShooting& shooting, Solver& solver, std::string_view name,
                     const VectorRef& from, const VectorRef& to,
                     const HomotopyOptions& options = {});

}  // namespace saltus
