// Multipliers of a solution by the names of the problem.
#pragma once

#include <vector>

#include "saltus/transcription/shooting_program.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {

/// Multipliers of terms, links, integrals and bounds, and the costates, in the order of the phases.
/// Empty if the point has no multipliers.
std::vector<Solution::Multiplier> multipliers_of(const ShootingProgram& program,
                                                 const NlpPoint& point);

}  // namespace saltus
