// Which pushes could the plain pendulum survive, in any direction on the ground?
//
// The capture point obeys xi' = omega (xi - p) + F / (m omega) with the centre of pressure p in the
// stance foot S until the landing at t_s, and in the hull of both feet from then on. Multiplied by
// e^(-omega t) and integrated: xi stays bounded if and only if
//   xi(0) + J u c / (m omega)  lies in  (1 - e) S + e hull(S, new foot)
// (Minkowski sum, e = e^(-omega t_s)), where the push in direction u counts with the mean c of
// e^(-omega t) while it lasts: (1 - e^(-omega T)) / (omega T) if its force is constant. The union
// over all places of the new foot within reach is (1 - e) S + e hull(S, foot + reach): convex, so
// the bound is where a ray leaves a polygon. Along an axis of the foot this is
// saltus/robots/model/standing_bound.hpp. On two feet S is their hull. Where a planner decides
// about number and times of steps the set is that of N steps,
// saltus/robots/model/capturability.hpp. A robot that swings angular momentum or lowers itself can
// do more, one with limits less.
#pragma once

#include <optional>

#include "saltus/robots/model/capturability.hpp"
#include "saltus/robots/walking/biped_problem.hpp"
#include "saltus/robots/walking/push.hpp"
#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/walking/step_logic.hpp"

namespace saltus::walking {

/// What the pendulum has to do with. Lengths in m, in the axes of the stance sole.
struct PendulumBound {
  double mass = 0.0;                      // kg
  double height = 0.0;                    // of the CoM, m
  Push push;                              // its shape and duration
  Point2 start{0.0, 0.0};                 // the CoM at rest
  FootRectangle stance_foot, swing_foot;  // each in its own contact frame
  Bounds reach_x, reach_y;                // where the swing sole's origin may land
  Side stance = Side::left;               // the foot at the origin
  std::optional<Point2> other_foot;       // the swing sole's origin, where it stands at the start
  std::optional<StepBounds> steps;        // of a planner that decides about their times

  /// Largest impulse (N s) in the direction of the angle (rad, from x to y) that is survived with
  /// a landing `landing` seconds after the push began, or standing. Throws DefinitionError for
  /// values that are not positive, a landing before the push ends, or a start beside the foot.
  double largest_impulse(double angle, std::optional<double> landing) const;
  /// The same in so many steps within `steps`, begun when they are of most use. On two feet either
  /// one may go first. Throws DefinitionError without limits.
  double largest_impulse_in(double angle, int count) const;

 private:
  double largest_impulse_within(const SupportPolygon& set, double angle) const;
  void check(double angle) const;
};

/// As the closed loop has it: CoM above the target at the height of the posture (on one foot its
/// sole's origin), where the controllers hold it; reach or fixed place as set, or the limits of the
/// planner of steps.
PendulumBound pendulum_bound(const Push& push, const Step& step, const SceneSettings& settings,
                             const RobotDescription& robot,
                             const std::optional<StepBounds>& steps = std::nullopt);

}  // namespace saltus::walking
