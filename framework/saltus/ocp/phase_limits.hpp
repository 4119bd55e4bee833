// Limits of a phase that become terms: integrals, soft bounds of components, bounds of algebraic
// states.
#pragma once

#include "saltus/ocp/phase_definition.hpp"

namespace saltus {

/// Throws DefinitionError with the phase and the integral if it is invalid.
void check(const PhaseDefinition& phase, const IntegralConstraint& integral);

}  // namespace saltus
