// The steps of a Function that was made of a formula.
#pragma once

#include "saltus/autodiff/formula_steps.hpp"
#include "saltus/model/function.hpp"

namespace saltus {

/// Traces the formula once more and writes down what it computes; compared with the function's own
/// values at some points. Throws DefinitionError where they differ, or if the function was not made
/// by make_function().
FormulaSteps steps_of(const Function& function);

/// Compares values at `points` arguments around `z`. Throws DefinitionError that begins with
/// `what`.
void check_steps(const FormulaSteps& steps, const Function& function, const VectorXd& z,
                 const char* what, int points = 3);

}  // namespace saltus
