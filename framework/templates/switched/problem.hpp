// A sledge slides from ice onto gravel: the problem, used by the program and its test.
#pragma once

#include <string>
#include <vector>

#include <saltus/ocp/problem.hpp>

inline constexpr double gravel_begins = 10.0;  // m
inline constexpr double finish = 15.0;         // m

// From rest to rest at the finish, in minimum time with a small effort. The dynamics change at the
// start of the gravel; the time of that switch is part of the solution.
saltus::OptimalControlProblem make_problem(double friction_of_gravel = 0.3);

inline const std::vector<std::string> state_names{"position [m]", "speed [m/s]"};
inline const std::vector<std::string> input_names{"pull [m/s^2]"};
