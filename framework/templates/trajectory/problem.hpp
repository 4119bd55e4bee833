// Swing-up of a pendulum: the problem, used by the program and its test.
#pragma once

#include <string>
#include <vector>

#include <saltus/ocp/problem.hpp>

// From hanging to upright in 3 s, at rest at both ends, with minimum torque.
saltus::OptimalControlProblem make_problem();

inline const std::vector<std::string> state_names{"angle [rad]", "rate [rad/s]"};
inline const std::vector<std::string> input_names{"torque [N m]"};
