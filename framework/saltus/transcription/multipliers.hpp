// Names the multipliers of a solution by phase and term.
#pragma once

#include <vector>

#include "saltus/transcription/shooting_program.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {

/// Multipliers of terms, links, integrals and bounds, and the costates, ordered by phase. Empty if
/// the point has no multipliers.
std::vector<Solution::Multiplier> multipliers_of(const ShootingProgram& program,
                                                 const NlpPoint& point);

}  // namespace saltus
