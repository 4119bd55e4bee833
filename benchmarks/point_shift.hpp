// The solution of one control tick as the start of the next: everything one stage earlier.
#pragma once

#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

/// Stage k of `to` begins where stage k + 1 of `from` ended, multipliers included; the last stages
/// keep what they had. Inputs of a stage whose number of inputs differs (a foot appears or
/// vanishes) are those of `guess`, and multipliers of rows that did not exist are zero. The states
/// after the last known one follow the dynamics. `out` is sized for the capacity of both. Does not
/// allocate.
void shift_by_one_stage(const StageQp& from, const StagePoint& solution, const StageQp& to,
                        const StagePoint& guess, StagePoint& out);

}  // namespace saltus::bench
