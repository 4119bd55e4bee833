// The solution of one control tick as the start of the next: everything one stage earlier.
#pragma once

#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

/// Copies stage k + 1 of `from` to stage k of `to`, including multipliers; the last stages keep
/// their values. If the number of inputs of a stage differs (a foot appears or vanishes), its
/// inputs are those of `guess`. Multipliers of new rows are zero. The states after the last known
/// one follow the dynamics. `out` is sized for the capacity of both. Does not allocate.
void shift_by_one_stage(const qp::StageQp& from, const qp::StagePoint& solution,
                        const qp::StageQp& to, const qp::StagePoint& guess, qp::StagePoint& out);

}  // namespace saltus::bench
