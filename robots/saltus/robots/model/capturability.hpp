// From which capture points can a pendulum on one foot or on two be stopped within N steps?
//
// xi' = omega (xi - p) with the centre of pressure p in what stands: to where xi is headed is
// bounded, however it is pushed meanwhile, if and only if the xi that it started from (plus what
// the push added, see problems/biped/survival/pendulum_bound.hpp) lies in a set that is found
// backwards. On a foot with the sole S no step is C_0 = S. A step takes the time t at least, e =
// e^(-omega t), to a place r of the reach R, from where n - 1 more may follow, on the other foot:
//   C_n = (1 - e) S + e hull(S, R + C_(n-1) mirrored).
// On two feet p may be in the hull D of both as long as it pays to wait, and either foot may be the
// one that stays:  C_n on two feet = hull(D, C_n on the left) united with hull(D, C_n on the
// right). After Koolen and others (2012), with soles and several feet; the union over all places is
// taken for their hull, so with two steps or more the sets are outer ones. Soles stay parallel.
#pragma once

#include <vector>

#include "saltus/robots/model/planar_sets.hpp"

namespace saltus {

/// Where and how soon feet can be put. Contact frames are parallel, lengths in m.
struct SteppingLimits {
  FootRectangle left, right;  ///< soles, each in its own contact frame
  std::vector<Point2> reach;  ///< corners of the places of a contact frame relative to that of the
                              ///< other foot: forward, and away from it
  double shortest = 0.3;      ///< time of a swing, s
};

/// The corners of a rectangle.
PlanarPoints corners_of(const Bounds& x, const Bounds& y);

/// On the stance foot, in its contact frame; omega in 1/s.
SupportPolygon capturable(const SteppingLimits& limits, Side stance, int steps, double omega);

/// On two feet, in the contact frame of the left one; `right` is where the other one stands. A
/// union: without steps one polygon, else one for each foot that may stay.
std::vector<SupportPolygon> capturable_on_two_feet(const SteppingLimits& limits,
                                                   const Point2& right, int steps, double omega);

}  // namespace saltus
