// Homotopy: a parameter moves in steps from an easy value to the wanted one, and each solution is
// the start of the next solve.
//
//     MultipleShooting shooting(swing_up, options);
//     const Homotopy way = solve_along(shooting, *solver, "gravity", no_gravity, earth);
//     if (way.ok()) way.solution.cost;
#pragma once

#include <string_view>
#include <vector>

#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// Options of a homotopy.
struct HomotopyOptions {
  double first_step = 0.25;  ///< fraction of the path; doubled on success, halved on failure
  double least_step = 1e-3;  ///< the homotopy fails below this step
};

/// Result of a homotopy.
struct Homotopy {
  Solution solution;     ///< at `reached`; if the first solve failed, the result of that solve
  double reached = 0.0;  ///< fraction of the path; 1: complete
  /// One solve of the homotopy.
  struct Step {
    double at = 0.0;      ///< fraction of the path
    double cost = 0.0;    ///< cost of the solution
    bool solved = false;  ///< the solve succeeded
    int iterations = 0;   ///< iterations of the solve
  };
  std::vector<Step> steps;  ///< all solves in the order of the attempts

  /// True if the wanted problem was solved.
  bool ok() const { return reached == 1.0 && solution.ok(); }
};

/// Moves parameter `name` of the problem along the straight line between two values. The shooting
/// keeps the value of the last successful solve. Throws DefinitionError for unknown names and wrong
/// sizes.
Homotopy solve_along(MultipleShooting& shooting, Solver& solver, std::string_view name,
                     const VectorRef& from, const VectorRef& to,
                     const HomotopyOptions& options = {});

}  // namespace saltus
