// A pole on a cart is kept upright: the problem, as the program and its test use it.
#pragma once

#include <string>
#include <vector>

#include <saltus/ocp/problem.hpp>

// What the controller looks ahead at: 1 s, the cart towards `target` (parameter, m), the pole up.
saltus::OptimalControlProblem make_problem();

inline const std::vector<std::string> state_names{"cart [m]", "pole [rad]", "cart [m/s]",
                                                  "pole [rad/s]"};
inline const std::vector<std::string> input_names{"force [N]"};
