// Which variables of a program stand for one quantity: a component of the state or of the input
// along all phases that have as many of them, a duration, a parameter.
#pragma once

#include "saltus/solver/program_scale.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// True if a nominal magnitude was declared, as far as its value tells: the default is 1. Of
/// states, inputs and durations PhaseDefinition knows more.
inline bool is_declared(double nominal) { return nominal != 1.0; }

/// Variables of each quantity whose nominal magnitude nobody declared; slacks belong to none.
Quantities undeclared_quantities(const ShootingProgram& program);

/// By what steps of a datum are measured: |value| or, where that is zero but for rounding, a share
/// of its nominal magnitude.
double size_of_datum(double value, double nominal, double share);

}  // namespace saltus
