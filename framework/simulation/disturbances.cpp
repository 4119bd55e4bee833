#include "saltus/simulation/disturbances.hpp"

#include <cmath>
#include <numbers>

namespace saltus {

double GaussianNoise::uniform() {
  constexpr double unit = 1.0 / 9007199254740992.0;  // 2^-53
  return (static_cast<double>(bits_() >> 11) + 1.0) * unit;
}

double GaussianNoise::operator()() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const double radius = std::sqrt(-2.0 * std::log(uniform()));
  const double angle = 2.0 * std::numbers::pi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

}  // namespace saltus
