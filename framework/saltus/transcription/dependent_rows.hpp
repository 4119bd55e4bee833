// Finds redundant or contradictory equations of a problem, for solvers that refuse more equations
// than unknowns.
#pragma once

#include <string>

#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// Empty if the equality rows are linearly independent at w. Otherwise one clause such as "100
/// equations for 90 free unknowns; phase 'flight', term 'landing', row 0 at t = 0.8 s follows from
/// the other equations or contradicts them". Prefers rows of terms to rows of the dynamics.
/// Factorises the Jacobian, so use it at set-up and after failed solves only.
std::string describe_dependent_rows(ShootingProgram& program, const VectorXd& w);

}  // namespace saltus
