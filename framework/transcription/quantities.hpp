// Which variables of a program stand for one quantity: a component of the state or of the input
// along all phases that have as many of them, a duration, a parameter.
#pragma once

#include "saltus/solver/program_scale.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// Variables of each quantity whose nominal magnitude is 1, as it is where nobody declared one;
/// slacks belong to none.
Quantities undeclared_quantities(const ShootingProgram& program);

/// By what steps of a datum are measured: |value| or, where that is zero but for rounding, a share
/// of its nominal magnitude.
double size_of_datum(double value, double nominal, double share);

}  // namespace saltus
