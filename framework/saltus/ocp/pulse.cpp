#include "saltus/ocp/pulse.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "saltus/ocp/schedule.hpp"

namespace saltus {

const char* describe(PulseShape shape) {
  constexpr const char* names[] = {"rectangle", "half_sine", "triangle"};
  return names[static_cast<int>(shape)];
}

double Pulse::fraction(double t) const {
  const double s = std::clamp((t - start) / duration, 0.0, 1.0);
  switch (shape) {
    case PulseShape::rectangle:
      return s;
    case PulseShape::half_sine:
      return 0.5 * (1.0 - std::cos(std::numbers::pi * s));
    case PulseShape::triangle:
      return s < 0.5 ? 2.0 * s * s : 1.0 - 2.0 * (1.0 - s) * (1.0 - s);
  }
  return s;
}

VectorXd Pulse::mean(double from, double to) const {
  if (to < start + same_instant || from > end() - same_instant)
    return VectorXd::Zero(direction.size());
  const bool is_within = from > start - same_instant && to < end() + same_instant;
  if (shape == PulseShape::rectangle && is_within)
    return direction * (impulse / duration);  // avoids rounding errors
  return direction * (impulse * (fraction(to) - fraction(from)) / (to - from));
}

}  // namespace saltus
