// The command line of `saltus robot`.
#pragma once

#include <string>

#include "saltus/app/program.hpp"
#include "saltus/robots/walking/biped_problem.hpp"

namespace saltus::survey {

/// `saltus robot check` and `saltus robot new`. The latter writes settings for `problem`, as `run`
/// names it, fitted from these defaults to the robot's size.
Verb robot_verb(const std::string& problem, const walking::BipedProblem& defaults);

}  // namespace saltus::survey
