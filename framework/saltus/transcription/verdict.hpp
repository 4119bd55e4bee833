// What a verification means for a solution: its status and its message.
#pragma once

#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/solution.hpp"
#include "saltus/verify/verify.hpp"

namespace saltus {

/// The plan of a solution, verified against the problem with the present data of the shooting.
VerificationDetail verify_plan(const MultipleShooting& shooting, const Solution& solution,
                               double resolution = infinity);
/// Verifies the plan unless ShootingOptions::accuracy says not to, and lets the status of a
/// solution that is ok() and its message follow.
void judge_plan(const MultipleShooting& shooting, Solution& solution);

}  // namespace saltus
