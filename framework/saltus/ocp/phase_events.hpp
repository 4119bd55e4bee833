// Short forms for state-triggered events inside a phase.
#pragma once

#include <string>

#include "saltus/model/crossing.hpp"
#include "saltus/ocp/phase_definition.hpp"

namespace saltus {

/// Makes the phase's dynamics active where guard < 0 and `above` where guard > 0. Throws
/// DefinitionError if the phase already has a surface, because the four regions would be ambiguous.
void add_surface(PhaseDefinition& phase, const std::string& event, Function guard, Function above);

/// Adds the jump x+ = reset(z) where the guard crosses zero, in all present and later modes of the
/// phase.
void add_reset(PhaseDefinition& phase, const std::string& event, Function guard, Crossing direction,
               Function reset);

}  // namespace saltus
