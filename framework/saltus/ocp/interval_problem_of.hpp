// The interval problem of a phase, as an integrator needs it.
#pragma once

#include "saltus/model/integrator.hpp"
#include "saltus/ocp/phase_definition.hpp"

namespace saltus {

/// The dynamics of the phase with algebraic equations and events. Has no running cost, no
/// derivatives with respect to parameters, and constant inputs.
IntervalProblem interval_problem_of(const PhaseDefinition& phase);

}  // namespace saltus
