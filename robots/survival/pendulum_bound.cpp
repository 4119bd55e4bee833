#include "saltus/robots/survival/pendulum_bound.hpp"

#include <fmt/format.h>

#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/model/planar_sets.hpp"

namespace saltus::walking {
namespace {

PlanarPoints corners(const Bounds& x, const Bounds& y) {
  PlanarPoints points(4, 2);
  points << x.upper, y.upper, x.lower, y.upper, x.lower, y.lower, x.upper, y.lower;
  return points;
}

// Mean of e^(-omega t), t from the start of the push, weighted with its force; by parts, as the
// impulse given up to t is what is known: e^(-omega T) + omega integral e^(-omega t) fraction(t)
// dt.
double mean_decay(const Push& push, double omega) {
  constexpr int intervals = 200;  // of Simpson's rule: error below 1e-9 for all shapes
  const double h = push.duration / intervals;
  double integral = 0.0;
  for (int i = 0; i <= intervals; ++i) {
    const double weight = i == 0 || i == intervals ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
    integral +=
        weight * h / 3.0 * std::exp(-omega * i * h) * impulse_fraction(push, push.start + i * h);
  }
  return std::exp(-omega * push.duration) + omega * integral;
}

}  // namespace

double PendulumBound::largest_impulse(double angle, std::optional<double> landing) const {
  if (!(mass > 0.0 && height > 0.0 && push.duration > 0.0) || !std::isfinite(angle))
    throw DefinitionError(fmt::format(
        "pendulum bound: mass {} kg, height {} m and duration {} s must be positive, angle {} rad "
        "finite",
        mass, height, push.duration, angle));
  if (landing && !(*landing >= push.duration))
    throw DefinitionError(
        fmt::format("pendulum bound: the foot lands after {} s, before the push of {} s ends",
                    *landing, push.duration));
  const PlanarPoints stance = corners(stance_foot.x, stance_foot.y);
  if (!SupportPolygon::hull(stance).contains(start))
    throw DefinitionError("pendulum bound: the CoM starts beside the stance foot");

  const double omega = pendulum_frequency(height);
  PlanarPoints reachable = stance;
  if (landing) {
    PlanarPoints both(8, 2);
    both << stance,
        corners(between(swing_foot.x.lower + reach_x.lower, swing_foot.x.upper + reach_x.upper),
                between(swing_foot.y.lower + reach_y.lower, swing_foot.y.upper + reach_y.upper));
    const double late = std::exp(-omega * *landing);
    reachable = weighted_sums(1.0 - late, stance, late, both);
  }
  const Point2 along(std::cos(angle), std::sin(angle));
  return distance_to_border(SupportPolygon::hull(reachable), start, along) * mass * omega /
         mean_decay(push, omega);
}

PendulumBound pendulum_bound(const Push& push, const Step& step, const SceneSettings& settings,
                             const RobotDescription& robot) {
  PendulumBound bound;
  bound.mass = robot.mass;
  const Scene scene = initial_scene(settings, robot);
  bound.height = scene.com_height;
  bound.push = push;
  bound.stance_foot = scene.stance_foot;
  bound.swing_foot = scene.swing_foot;
  Bounds away;
  if (step.placement == Placement::fixed) {
    bound.reach_x = exactly(step.fixed_place[0]);
    away = exactly(step.fixed_place[1]);
  } else {
    bound.reach_x = between(-step.forward_max, step.forward_max);
    away = between(step.lateral_min, step.lateral_max);
  }
  bound.reach_y = settings.stance == Stance::right ? away : between(-away.upper, -away.lower);
  return bound;
}

}  // namespace saltus::walking
