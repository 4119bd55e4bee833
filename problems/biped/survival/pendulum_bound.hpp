// Largest pushes that the plain pendulum can survive, in any horizontal direction.
//
// The capture point obeys xi' = omega (xi - p) + F / (m omega) with the centre of pressure p in the
// stance foot S until the landing at t_s, and then in the hull of both feet. Multiply by
// e^(-omega t) and integrate: xi stays bounded if and only if
//   xi(0) + J u c / (m omega)  lies in  (1 - e) S + e hull(S, new foot)
// (Minkowski sum, e = e^(-omega t_s)). c is the mean of e^(-omega t) over the push in direction u:
// (1 - e^(-omega T)) / (omega T) if its force is constant. The union over all places of the new
// foot within reach is (1 - e) S + e hull(S, foot + reach). It is convex, so the bound is the point
// at which a ray leaves a polygon. Along an axis of the foot this equals
// tests/support/standing_bound.hpp. On two feet S is their hull. If a planner chooses the number
// and the times of the steps, the set is that of N steps, saltus/robots/model/capturability.hpp. A
// robot that uses angular momentum or lowers its CoM can survive more; a robot with joint and
// torque limits can survive less.
#pragma once

#include <optional>

#include "saltus/robots/model/capturability.hpp"
#include "saltus/robots/walking/biped_problem.hpp"
#include "saltus/robots/walking/push.hpp"
#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/walking/step_logic.hpp"

namespace saltus::robots::walking {

/// Pendulum, feet, reach and push. Lengths in m, in the axes of the stance sole.
struct PendulumBound {
  double mass = 0.0;                      // kg
  double height = 0.0;                    // height of the CoM, m
  Push push;                              // shape and duration
  Point2 start{0.0, 0.0};                 // initial CoM, at rest
  FootRectangle stance_foot, swing_foot;  // each in its own contact frame
  Bounds reach_x, reach_y;                // where the swing sole's origin may land
  Side stance = Side::left;               // the foot at the origin
  std::optional<Point2> other_foot;       // initial origin of the swing sole if it is on the ground
  std::optional<BipedProblem::StepBounds> steps;  // limits of a planner that chooses the step times

  /// Largest survivable impulse (N s) at `angle` (rad, from x to y), with a landing `landing`
  /// seconds after the push began, or without a step. Throws DefinitionError for values that are
  /// not positive, a landing before the push ends, or a start outside the foot.
  double largest_impulse(double angle, std::optional<double> landing) const;
  /// The same with `count` steps within the limits `steps`, at the best times. On two feet either
  /// foot may step first. Throws DefinitionError if `steps` is empty.
  double largest_impulse_in(double angle, int count) const;

 private:
  double largest_impulse_within(const SupportPolygon& set, double angle) const;
  void check(double angle) const;
};

/// The bound for the closed loop: CoM above its target (on one foot the sole's origin), at the
/// height of the posture, where the controllers hold it. The reach is the one set, a fixed place,
/// or the limits of the step planner.
PendulumBound pendulum_bound(const Push& push, const Step& step, const SceneSettings& settings,
                             const RobotDescription& robot,
                             const std::optional<BipedProblem::StepBounds>& steps = std::nullopt);

}  // namespace saltus::robots::walking
