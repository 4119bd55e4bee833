// A pendulum is swung up: the problem, as the program and its test use it.
#pragma once

#include <string>
#include <vector>

#include <saltus/ocp/problem.hpp>

// From hanging to upright in 3 s, at rest at both ends, with as little torque as possible.
saltus::OptimalControlProblem make_problem();

inline const std::vector<std::string> state_names{"angle [rad]", "rate [rad/s]"};
inline const std::vector<std::string> input_names{"torque [N m]"};
