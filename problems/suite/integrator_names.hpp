// Integrators by name, for runs of the library.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "saltus/model/integrator.hpp"

namespace saltus {

enum class Scheme { own, runge_kutta4, runge_kutta8, cvodes, arkode, zero_order_hold };
/// The names for Settings::choice().
const std::vector<std::pair<std::string, Scheme>>& schemes();
/// `tolerance` is for CVODES and ARKODE. The result is empty for the integrator of the case.
IntegratorChoice make_scheme(Scheme scheme, double tolerance);

}  // namespace saltus
