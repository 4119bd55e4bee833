#include "problems/biped/survival/pendulum_bound.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/capture_point.hpp"

namespace saltus::robots::walking {
namespace {

// Mean of e^(-omega t) weighted with the force, t from the start of the push. Integration by parts
// uses the known impulse fraction up to t:
// e^(-omega T) + omega integral e^(-omega t) fraction(t) dt.
double mean_decay(const Push& push, double omega) {
  constexpr int intervals = 200;  // Simpson's rule: error below 1e-9 for all shapes
  const double h = push.duration / intervals;
  double integral = 0.0;
  for (int i = 0; i <= intervals; ++i) {
    const double weight = i == 0 || i == intervals ? 1.0 : i % 2 == 1 ? 4.0 : 2.0;
    integral += weight * h / 3.0 * std::exp(-omega * i * h) * push.fraction(push.start + i * h);
  }
  return std::exp(-omega * push.duration) + omega * integral;
}

}  // namespace

void PendulumBound::check(double angle) const {
  if (!(mass > 0.0 && height > 0.0 && push.duration > 0.0) || !std::isfinite(angle))
    throw DefinitionError(fmt::format(
        "pendulum bound: mass {} kg, height {} m and duration {} s must be positive, angle {} rad "
        "finite",
        mass, height, push.duration, angle));
}

double PendulumBound::largest_impulse_within(const SupportPolygon& set, double angle) const {
  if (!set.contains(start))
    throw DefinitionError("pendulum bound: the CoM starts outside the support polygon");
  const double omega = pendulum_frequency(height);
  const Point2 along(std::cos(angle), std::sin(angle));
  return distance_to_border(set, start, along) * mass * omega / mean_decay(push, omega);
}

double PendulumBound::largest_impulse(double angle, std::optional<double> landing) const {
  check(angle);
  if (landing && !(*landing >= push.duration))
    throw DefinitionError(
        fmt::format("pendulum bound: the foot lands after {} s, before the push of {} s ends",
                    *landing, push.duration));
  PlanarPoints ground = corners_of(stance_foot.x, stance_foot.y);
  if (other_foot) {
    const PlanarPoints sole = corners_of(swing_foot.x, swing_foot.y);
    ground.conservativeResize(8, 2);
    ground.bottomRows(4) = sole.rowwise() + other_foot->transpose();
  } else if (!SupportPolygon::hull(ground).contains(start)) {
    throw DefinitionError("pendulum bound: the CoM starts outside the stance foot");
  }
  PlanarPoints reachable = ground;
  if (landing && !other_foot) {
    PlanarPoints both(8, 2);
    both << ground,
        corners_of(between(swing_foot.x.lower + reach_x.lower, swing_foot.x.upper + reach_x.upper),
                   between(swing_foot.y.lower + reach_y.lower, swing_foot.y.upper + reach_y.upper));
    const double late = std::exp(-pendulum_frequency(height) * *landing);
    reachable = weighted_sums(1.0 - late, ground, late, both);
  }
  return largest_impulse_within(SupportPolygon::hull(reachable), angle);
}

double PendulumBound::largest_impulse_in(double angle, int count) const {
  check(angle);
  if (!steps)
    throw DefinitionError(
        "pendulum bound: a bound with steps needs the limits of the step planner");
  const bool on_left = stance == Side::left;
  const SteppingLimits limits{on_left ? stance_foot : swing_foot,
                              on_left ? swing_foot : stance_foot, steps->reach, steps->shortest};
  const double omega = pendulum_frequency(height);
  if (!other_foot) return largest_impulse_within(capturable(limits, stance, count, omega), angle);
  if (!on_left)
    throw DefinitionError("pendulum bound: on two feet, the left foot must be at the origin");
  double largest = 0.0;
  for (const SupportPolygon& set : capturable_on_two_feet(limits, *other_foot, count, omega))
    largest = std::max(largest, largest_impulse_within(set, angle));
  return largest;
}

PendulumBound pendulum_bound(const Push& push, const Step& step, const SceneSettings& settings,
                             const RobotDescription& robot,
                             const std::optional<BipedProblem::StepBounds>& steps) {
  PendulumBound bound;
  bound.steps = steps;
  bound.mass = robot.mass;
  const Scene scene = initial_scene(settings, robot);
  bound.height = scene.com_height;
  bound.push = push;
  bound.stance_foot = scene.stance_foot;
  bound.swing_foot = scene.swing_foot;
  bound.stance = scene.side;
  if (scene.two_feet) {
    bound.other_foot = scene.swing.position.head<2>();
    bound.start = scene.target_point();
  }
  Bounds away;
  if (step.placement == Step::Placement::fixed) {
    bound.reach_x = exactly(step.fixed_place[0]);
    away = exactly(step.fixed_place[1]);
  } else {
    bound.reach_x = between(-step.forward_max, step.forward_max);
    away = between(step.lateral_min, step.lateral_max);
  }
  bound.reach_y = settings.stance == Stance::right ? away : between(-away.upper, -away.lower);
  return bound;
}

}  // namespace saltus::robots::walking
