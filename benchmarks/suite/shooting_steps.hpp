// The functions of a shooting program as elementary steps: dynamics together with their integrator,
// costs, constraints and jumps, so that others can solve the same program by their own means.
#pragma once

#include <vector>

#include "saltus/autodiff/formula_steps.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus::bench {

struct ShootingSteps {
  std::vector<FormulaSteps> functions;
  std::vector<int> function_of;  ///< per block of the program: index into `functions`, -1: a block
                                 ///< none of whose outputs counts
};

/// Every function is compared with the program's own. Throws DefinitionError, in a sentence, for
/// what cannot be written as steps: implicit integrators, events inside intervals, algebraic
/// equations, references that vary in time.
ShootingSteps shooting_steps(const ShootingProgram& program, const IntegratorScheme& scheme,
                             const VectorXd& start);

}  // namespace saltus::bench
