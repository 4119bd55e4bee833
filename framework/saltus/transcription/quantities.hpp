// Groups the variables of a program by quantity: a component of the state or input in all phases of
// the same size, a duration, a parameter.
#pragma once

#include "saltus/solver/optimum_check.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// True if the value indicates a declared nominal magnitude; the default is 1. PhaseDefinition has
/// exact flags for states, inputs and durations.
inline bool is_declared(double nominal) { return nominal != 1.0; }

/// Variables of each quantity without a declared nominal magnitude. Slacks belong to no quantity.
Quantities undeclared_quantities(const ShootingProgram& program);

/// Magnitude for difference steps of a datum: |value|, or a share of its nominal magnitude if the
/// value is zero to rounding.
double datum_magnitude(double value, double nominal, double share);

}  // namespace saltus
