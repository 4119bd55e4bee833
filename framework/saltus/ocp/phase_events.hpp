// State-triggered events inside a phase, in the short forms that the user writes.
#pragma once

#include <string>

#include "saltus/model/crossing.hpp"
#include "saltus/ocp/phase_definition.hpp"

namespace saltus {

/// The phase's dynamics hold where guard < 0, `above` where guard > 0. Throws DefinitionError when
/// the phase has a surface already: which of four fields holds where would be a guess.
void add_surface(PhaseDefinition& phase, const std::string& event, Function guard, Function above);

/// x+ = reset(z) where the guard crosses zero, in every mode that the phase has or will have.
void add_reset(PhaseDefinition& phase, const std::string& event, Function guard, Crossing direction,
               Function reset);

}  // namespace saltus
