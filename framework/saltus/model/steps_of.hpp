// Elementary steps of a Function made from a formula.
#pragma once

#include "saltus/autodiff/formula_steps.hpp"
#include "saltus/model/function.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus {

/// The steps recorded by make_function(), after comparing them with the function's values at some
/// points. Throws DefinitionError if they differ or if make_function() did not make the function.
FormulaSteps steps_of(const Function& function);

/// The function that evaluates these steps, for formulas that are known at run time only. Its
/// derivatives and patterns are exact, as those of make_function(). Throws DefinitionError like it.
Function function_of(FormulaSteps steps, const FormulaName& name = {});

/// Compares values at `points` arguments around `z`. Throws DefinitionError with a message that
/// begins with `what`.
void check_steps(const FormulaSteps& steps, const Function& function, const VectorXd& z,
                 const char* what, int points = 3);

}  // namespace saltus
