// A step of a minimum-jerk motion whose goal and end may change.
#pragma once

#include <algorithm>

namespace saltus::robots {

/// Remaining time below which a minimum-jerk motion is no longer changed, s.
inline constexpr double shortest_motion = 0.01;

/// One step of `dt` (s) of the quintic from (p, v, a) to rest at `goal` in T (s). V: number or
/// vector. Near the end the motion coasts to rest.
template <class V>
void advance_minimum_jerk(const V& goal, double T, double dt, V& p, V& v, V& a) {
  if (T <= shortest_motion) {
    p += (goal - p) * std::min(1.0, dt / std::max(T, dt));
    v *= 0.0;
    a *= 0.0;
    return;
  }
  const V jerk = (60.0 * (goal - p) - (36.0 * v + 9.0 * a * T) * T) / (T * T * T);
  p += dt * (v + dt * (0.5 * a + dt * jerk / 6.0));
  v += dt * (a + 0.5 * dt * jerk);
  a += dt * jerk;
}

}  // namespace saltus::robots
