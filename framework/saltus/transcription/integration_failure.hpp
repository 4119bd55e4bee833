// Describes which interval of a plan could not be integrated, and why. Used after failed solves.
#pragma once

#include <string>

#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// One clause about the first interval that cannot be integrated at w: "phase 'flight', interval 3
/// from t = 0.8 s: at t = 0.9 s in mode ...". Names the running cost or integral if the dynamics
/// alone can be integrated. If all intervals can be integrated, describes the last failure of an
/// integrator. Empty if there is none.
std::string describe_integration_failure(const ShootingProgram& program, const VectorXd& w);

}  // namespace saltus
