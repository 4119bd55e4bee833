// N-step capturable sets: the capture points from which a pendulum on one or two feet can be
// stopped within N steps.
//
// The capture point obeys xi' = omega (xi - p), with the centre of pressure p inside the feet on
// the ground. It can be kept bounded, whatever the push does meanwhile, if and only if its start
// lies in a set found by a backward recursion. (The start includes the effect of the push, see
// problems/biped/survival/pendulum_bound.hpp.) On a foot with the sole S, zero steps give C_0 = S.
// A step takes at least the time t; let e = e^(-omega t). It ends at a place r of the reach R, from
// which n - 1 more steps on the other foot may follow:
//   C_n = (1 - e) S + e hull(S, R + C_(n-1) mirrored).
// On two feet, p may be anywhere in the hull D of both feet while the robot waits, and either foot
// may be the one that stays:
//   C_n on two feet = hull(D, C_n on the left) united with hull(D, C_n on the right).
// After Koolen and others (2012), extended to soles of finite size and to two feet. The union over
// all places is replaced by its hull, so for two or more steps the sets are outer approximations.
// All soles are parallel.
#pragma once

#include <vector>

#include "saltus/robots/model/planar_sets.hpp"

namespace saltus::robots {

/// Limits on the place and the duration of steps. Contact frames are parallel; lengths are in m.
struct SteppingLimits {
  FootRectangle left, right;  ///< soles, each in its own contact frame
  std::vector<Point2> reach;  ///< corners of the region that a contact frame can reach, in the
                              ///< frame of the other foot: forward, and away from it
  double shortest = 0.3;      ///< shortest time of a swing, s
};

/// The four corners of a rectangle, m.
PlanarPoints corners_of(const Bounds& x, const Bounds& y);

/// Capturable set on the stance foot within `steps` steps, in its contact frame; omega in 1/s.
SupportPolygon capturable(const SteppingLimits& limits, Side stance, int steps, double omega);

/// Capturable set on two feet, as a union of polygons in the contact frame of the left foot.
/// `right` is the position of the right foot. Without steps it is one polygon, otherwise one
/// polygon for each foot that may stay.
std::vector<SupportPolygon> capturable_on_two_feet(const SteppingLimits& limits,
                                                   const Point2& right, int steps, double omega);

}  // namespace saltus::robots
