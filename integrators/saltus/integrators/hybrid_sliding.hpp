// Filippov's convention: the field that keeps a trajectory on a surface g = 0 towards which both
// adjacent fields point, and its exit conditions.
//
// With r = g_t + g_x f on either side, r_below > 0 > r_above (guard negative below),
//   f_s = (1 - a) f_below + a f_above,   a = r_below / (r_below - r_above),
// so that g_t + g_x f_s = 0. The trajectory leaves the surface where r_below or r_above becomes
// zero. There a is 0 or 1 and the field is continuous. A. F. Filippov, Differential Equations with
// Discontinuous Righthand Sides, 1988.
#pragma once

#include "saltus/model/function.hpp"

namespace saltus {

/// sign * (g_t + g_x f) as a function of z, with its exact gradient. Has values and Jacobians only.
Function surface_rate(const Arguments& sizes, Function guard, Function dynamics, double sign);

/// (1 - a) below + a above, with a from the guard and the dynamics on both sides. `below` and
/// `above` are the dynamics or running costs. Has values and Jacobians only.
Function sliding_mix(const Arguments& sizes, Function guard, Function dynamics_below,
                     Function dynamics_above, Function below, Function above);

}  // namespace saltus
