// Which interval of a plan could not be integrated, and why? For solves that failed.
#pragma once

#include <string>

#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// One clause, "phase 'flight', interval 3 from t = 0.8 s: at t = 0.9 s in mode ...", on the first
/// interval that cannot be integrated at w. It names the running cost or integral if the dynamics
/// alone can be integrated. Otherwise on the most recent failure that an integrator can describe;
/// empty if there is none.
std::string name_integration_failure(const ShootingProgram& program, const VectorXd& w);

}  // namespace saltus
