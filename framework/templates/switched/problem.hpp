// A sledge from ice onto gravel: the problem, as the program and its test use it.
#pragma once

#include <string>
#include <vector>

#include <saltus/ocp/problem.hpp>

inline constexpr double gravel_begins = 10.0;  // m
inline constexpr double finish = 15.0;         // m

// From rest to rest at the finish, in little time and without hurting the dogs. The dynamics change
// where the gravel begins; when that is, the solution decides.
saltus::OptimalControlProblem make_problem(double friction_of_gravel = 0.3);

inline const std::vector<std::string> state_names{"position [m]", "speed [m/s]"};
inline const std::vector<std::string> input_names{"pull [m/s^2]"};
