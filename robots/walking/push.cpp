#include "saltus/robots/walking/push.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "saltus/app/settings.hpp"
#include "saltus/ocp/window.hpp"

namespace saltus::walking {

const char* describe(PushShape shape) {
  constexpr const char* names[] = {"rectangle", "half_sine", "triangle"};
  return names[static_cast<int>(shape)];
}

double impulse_fraction(const Push& push, double t) {
  const double s = std::clamp((t - push.start) / push.duration, 0.0, 1.0);
  switch (push.shape) {
    case PushShape::rectangle:
      return s;
    case PushShape::half_sine:
      return 0.5 * (1.0 - std::cos(std::numbers::pi * s));
    case PushShape::triangle:
      return s < 0.5 ? 2.0 * s * s : 1.0 - 2.0 * (1.0 - s) * (1.0 - s);
  }
  return s;
}

Vec<double, 3> mean_push_force(const Push& push, double from, double to) {
  const double end = push.end();
  if (to < push.start + same_instant || from > end - same_instant) return Vec<double, 3>::Zero();
  const Vec<double, 3> direction = push.direction.normalized();
  const bool within = from > push.start - same_instant && to < end + same_instant;
  if (push.shape == PushShape::rectangle && within)
    return direction * (push.impulse / push.duration);  // without rounding
  const double fraction = impulse_fraction(push, to) - impulse_fraction(push, from);
  return direction * (push.impulse * fraction / (to - from));
}

Vec<double, 3> total_push_force(std::span<const Push> pushes, double from, double to) {
  Vec<double, 3> force = Vec<double, 3>::Zero();
  for (const Push& push : pushes) force += mean_push_force(push, from, to);
  return force;
}

void declare_settings(Settings& s, Push& push) {
  s.number("push.impulse", push.impulse, "N s", "size of the push", between(0.0, 1e4));
  s.vector("push.direction", push.direction, "", "direction of the push, world axes",
           between(-1e6, 1e6));
  s.number("push.duration", push.duration, "s", "how long it lasts", between(1e-4, 60.0));
  s.number("push.start", push.start, "s", "when it begins", between(0.0, 600.0));
  s.choice<PushShape>("push.shape", push.shape,
                      {{describe(PushShape::rectangle), PushShape::rectangle},
                       {describe(PushShape::half_sine), PushShape::half_sine},
                       {describe(PushShape::triangle), PushShape::triangle}},
                      "of the force over time; the impulse is the same");
  s.rule({"push.direction"}, [&push] {
    return push.direction.norm() >= 1e-6 ? "" : "push.direction must not be zero, nor near it";
  });
}

void declare_point_of_push(Settings& s, Push& push) {
  s.text("push.link", push.link, "whole body: the link that is pushed (the centroidal model: CoM)");
  s.vector("push.point", push.point, "m", "whole body: where on that link, in its frame");
}

}  // namespace saltus::walking
