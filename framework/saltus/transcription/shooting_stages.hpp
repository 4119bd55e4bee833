// Assigns the variables and rows of a shooting program to stages.
#pragma once

#include "saltus/qp/qp_result.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// One stage per node of every phase, including the last node, whose dynamics are the jump. Unknown
/// parameters and free durations are global. Change costs and ends of input ramps require copies of
/// inputs in the next stage.
qp::StageStructure stage_structure(const ShootingProgram& program);

}  // namespace saltus
