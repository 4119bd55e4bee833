// `saltus control`: drives a robot in another process.
#pragma once

#include "problems/biped/configurable_biped.hpp"
#include "saltus/app/program.hpp"

namespace saltus::robots::walking {

/// Runs the BalanceController of a problem with these defaults against a robot that is reached
/// through a link (docs/robot_link.md), or writes its model for MuJoCo.
Verb control_verb(const ConfigurableBiped& defaults);

}  // namespace saltus::robots::walking
