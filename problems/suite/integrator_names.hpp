// Integrators by name, for runs of the library.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "saltus/model/integrator.hpp"

namespace saltus {

enum class Scheme { own, runge_kutta4, runge_kutta8, cvodes, arkode, zero_order_hold };
/// As users write them, for Settings::choice().
const std::vector<std::pair<std::string, Scheme>>& schemes();
/// `tolerance` is that of CVODES and ARKODE. Empty: the case's own.
IntegratorChoice make_scheme(Scheme scheme, double tolerance);

}  // namespace saltus
