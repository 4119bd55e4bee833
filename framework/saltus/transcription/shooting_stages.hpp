// Which variables and rows of a shooting program make up which stage?
#pragma once

#include "saltus/qp/stage_structure.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// A stage per node of every phase, the last node of a phase included: its dynamics are the jump.
/// Unknown parameters and free durations are global. Inputs are carried on for the sake of change
/// costs, and of the far ends of their ramps.
StageStructure stage_structure(const ShootingProgram& program);

}  // namespace saltus
