// The functions of a shooting program as elementary steps: dynamics with their integrator, costs,
// constraints and jumps, so that other solvers can solve the same program.
#pragma once

#include <vector>

#include "saltus/autodiff/formula_steps.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus::bench {

struct ShootingSteps {
  std::vector<FormulaSteps> functions;
  std::vector<int> function_of;  ///< index into `functions` per block of the program; -1: no output
                                 ///< of the block is used
};

/// Compares every function with that of the program. Throws DefinitionError for functions that
/// cannot be written as steps: implicit integrators, events inside intervals, algebraic equations,
/// references that vary in time.
ShootingSteps shooting_steps(const ShootingProgram& program, const IntegratorScheme& scheme,
                             const VectorXd& start);

}  // namespace saltus::bench
