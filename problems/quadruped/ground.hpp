// Uneven ground: a sum of random waves.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <numbers>

#include "saltus/autodiff/math.hpp"
#include "saltus/core/random.hpp"

namespace saltus::quadruped {

struct Ground {
  struct Wave {
    double kx = 0.0, ky = 0.0, phase = 0.0, height = 0.0;  // rad/m, rad/m, rad, m
  };
  std::array<Wave, 8> waves;

  Ground() = default;
  /// Waves of 0.4 to 1.2 m length with a total root mean square of height / 2, so that the ground
  /// is within `height` (m) of zero almost everywhere.
  Ground(double height, std::uint64_t seed) {
    Random random(seed);
    for (Wave& wave : waves) {
      const double k = 2.0 * std::numbers::pi / random.uniform(0.4, 1.2);
      const double towards = random.uniform(0.0, 2.0 * std::numbers::pi);
      wave = {k * std::cos(towards), k * std::sin(towards),
              random.uniform(0.0, 2.0 * std::numbers::pi), 0.25 * height};
    }
  }

  template <class S>
  S operator()(const S& x, const S& y) const {
    S z(0.0);
    for (const Wave& wave : waves) z += wave.height * sin(wave.kx * x + wave.ky * y + wave.phase);
    return z;
  }

  /// Rate at which the ground height below a moving point changes (m/s).
  template <class S>
  S rise(const S& x, const S& y, const S& vx, const S& vy) const {
    S rate(0.0);
    for (const Wave& wave : waves)
      rate +=
          wave.height * (wave.kx * vx + wave.ky * vy) * cos(wave.kx * x + wave.ky * y + wave.phase);
    return rate;
  }
};

}  // namespace saltus::quadruped
