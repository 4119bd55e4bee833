// A controller balances a pole on a cart: the problem, used by the program and its test.
#pragma once

#include <string>
#include <vector>

#include <saltus/ocp/problem.hpp>

// Horizon of 1 s: moves the cart towards `target` (parameter, m) and keeps the pole upright.
saltus::OptimalControlProblem make_problem();

inline const std::vector<std::string> state_names{"cart [m]", "pole [rad]", "cart [m/s]",
                                                  "pole [rad/s]"};
inline const std::vector<std::string> input_names{"force [N]"};
