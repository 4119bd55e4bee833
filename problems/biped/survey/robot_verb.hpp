// The command line of `saltus robot`.
#pragma once

#include <string>

#include "problems/biped/configurable_biped.hpp"
#include "saltus/app/program.hpp"

namespace saltus::survey {

/// `saltus robot check` and `saltus robot new`. The latter writes settings for `problem` (its name
/// in `saltus run`), scaled from these defaults to the robot's size.
Verb robot_verb(const std::string& problem, const walking::ConfigurableBiped& defaults);

}  // namespace saltus::survey
