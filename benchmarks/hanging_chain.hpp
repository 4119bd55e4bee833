// A chain of five masses in the air: one end is fixed, the other is moved by a robot. A nonlinear
// program of 21 states, 3 inputs and 40 intervals, case C05 of the benchmarks (without its wall).
//
// Masses 0 to 4 at p_0 = 0 .. p_4, springs between neighbours. With d = p_(i+1) - p_i, the spring
// pulls with D (1 - L / |d|) d; the three masses in between obey m a = sum of pulls + m g, the last
// one moves with the velocity u. State (p_1, p_2, p_3, p_4, v_1, v_2, v_3).
#pragma once

#include <cmath>
#include <filesystem>

#include "saltus/core/types.hpp"

namespace saltus::bench {

struct HangingChain {
  static constexpr int between = 3, nx = 3 * (2 * between + 1), nu = 3, intervals = 40;
  static constexpr int end = 3 * between;  // index of p_4 in the state
  static constexpr double mass = 0.033, spring = 1.0, rest_length = 0.033;   // kg, N/m, m
  static constexpr double gravity = 9.81, sample = 0.2, fastest = 1.0;       // m/s^2, s, m/s
  static constexpr int substeps = 2;                                         // RK4 steps per sample
  static constexpr double end_position = rest_length * (between + 1) * 6.0;  // reference, m

  template <class S>
  Vec<S, nx> operator()(const S&, const Vec<S, nx>& x, const Vec<S, nu>& u) const {
    using std::sqrt;
    Vec<S, nx> rate;
    for (int i = 0; i < 3 * between; ++i) {
      rate[i] = x[end + 3 + i];
      rate[end + 3 + i] = S(i % 3 == 2 ? -gravity : 0.0);
    }
    for (int axis = 0; axis < 3; ++axis) rate[end + axis] = u[axis];
    for (int i = 0; i <= between; ++i) {
      Vec<S, 3> d;
      for (int axis = 0; axis < 3; ++axis)
        d[axis] = i == 0 ? x[axis] : S(x[3 * i + axis] - x[3 * (i - 1) + axis]);
      const S length = sqrt(d[0] * d[0] + d[1] * d[1] + d[2] * d[2]);
      const S pull = (spring / mass) * (1.0 - rest_length / length);
      for (int axis = 0; axis < 3; ++axis) {
        const S force = pull * d[axis];
        if (i < between) rate[end + 3 + 3 * i + axis] = rate[end + 3 + 3 * i + axis] - force;
        if (i > 0) rate[end + 3 * i + axis] = rate[end + 3 * i + axis] + force;
      }
    }
    return rate;
  }
};

/// Frozen data: the state at rest with the end at `end_position`, and the start of the recovery.
struct ChainData {
  Vec<double, HangingChain::nx> reference, start;
};
/// Throws InputError with the name of the file and the mistake.
ChainData read_chain(const std::filesystem::path& file);

}  // namespace saltus::bench
