#include "saltus/simulation/disturbances.hpp"

#include <cmath>
#include <numbers>

namespace saltus {

double GaussianNoise::operator()() {
  if (has_spare_) {
    has_spare_ = false;
    return spare_;
  }
  const auto uniform = [this] { return random_.uniform(0.0, 1.0) + 0x1.0p-53; };  // in (0, 1]
  const double radius = std::sqrt(-2.0 * std::log(uniform()));
  const double angle = 2.0 * std::numbers::pi * uniform();
  spare_ = radius * std::sin(angle);
  has_spare_ = true;
  return radius * std::cos(angle);
}

}  // namespace saltus
