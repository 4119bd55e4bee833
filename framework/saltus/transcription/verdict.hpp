// Consequences of a verification for a solution: its status and its message.
#pragma once

#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/solution.hpp"
#include "saltus/verify/verify.hpp"

namespace saltus {

/// Verifies the plan of a solution against the problem with the current data of the shooting.
VerificationDetail verify_plan(const MultipleShooting& shooting, const Solution& solution,
                               double resolution = infinity);
/// Verifies the plan unless ShootingOptions::accuracy disables it. Updates status and message of a
/// solution that is ok().
void apply_verification(const MultipleShooting& shooting, Solution& solution);

}  // namespace saltus
