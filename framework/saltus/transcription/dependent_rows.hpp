// Which equations of a problem say the same twice, or contradict one another? For solvers that
// refuse more equations than unknowns.
#pragma once

#include <string>

#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// One clause, "100 equations for 90 free unknowns; phase 'flight', term 'landing', row 0 at t =
/// 0.8 s follows from the other equations or contradicts them", or an empty string if the equality
/// rows are independent at w. Among dependent rows it names those of terms, not the dynamics.
/// Factorises the Jacobian; set-up and failed solves only.
std::string name_dependent_rows(ShootingProgram& program, const VectorXd& w);

}  // namespace saltus
