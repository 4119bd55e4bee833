// What an integrator is told of a phase.
#pragma once

#include "saltus/model/integrator.hpp"
#include "saltus/ocp/phase_definition.hpp"

namespace saltus {

/// One interval of the phase: its dynamics with algebraic equations and events inside. Without a
/// running cost, without derivatives with respect to parameters, inputs held.
IntervalProblem interval_of(const PhaseDefinition& phase);

}  // namespace saltus
