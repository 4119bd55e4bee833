// Upper bounds on the pushes that a robot can survive, standing on one foot or with one step.
//
// Model: linear inverted pendulum of height z with a flywheel, pushed by the constant force J / T
// for the time T, along one axis. Coordinates are along the push, from the CoM at rest (t = 0). The
// centre of pressure p reaches at most the edge of the foot, at the distance d0. The capture point
// obeys
//   xi' = omega (xi - p) + (F - H'/z) / (m omega),   H(0) = 0,  |H'| <= torque,
// where H is the angular momentum about the CoM, positive in the direction that brakes. Multiply by
// e^(-omega t) and integrate, with p at the edge throughout (any other p is worse) and the H' term
// integrated by parts. The robot stops with its capture point on the foot and H(t_end) = 0 if and
// only if
//   J (1 - e^(-omega T)) / (m omega^2 T) - d0 <= 1/(m z) integral_0^t_end e^(-omega t) H(t) dt.
// The right side grows with H(t) at every t. So the best H for a peak value h is the largest one
// that its slope allows: H(t) = min(torque t, h, torque (t_end - t)). All integrals have a closed
// form. No controller that keeps |H| <= h on this model survives a larger push.
#pragma once

#include "saltus/core/bounds.hpp"

namespace saltus::robots {

/// The situation before the push.
struct StandingPush {
  double mass = 0.0;              // m, kg
  double height = 0.0;            // height z of the CoM above the contact plane, m
  double distance_to_edge = 0.0;  // d0, from the CoM to the edge of the foot along the push, m
  double duration = 0.1;          // duration T of the push, s
  double torque = infinity;       // largest |H'|, Nm
  double settle_time = 2.0;       // t_end, from the start of the push, s; not before its end
};

/// The smallest peak |H| (Nms) with which the robot survives an impulse (N s) standing. Zero if the
/// plain pendulum survives it, infinity if the torque limit makes it impossible. Throws
/// DefinitionError for values that are not positive, for settle_time < duration, and for NaN.
double least_peak_angular_momentum(double impulse, const StandingPush& push);

/// The largest impulse (N s) that the robot survives standing with |H| <= peak (Nms). peak = 0 is
/// the plain pendulum: m omega^2 T d0 / (1 - e^(-omega T)). Throws DefinitionError like
/// least_peak_angular_momentum().
double largest_impulse_standing(double peak_angular_momentum, const StandingPush& push);

/// The largest impulse (N s) that the plain pendulum survives with one step. The foot lands
/// `landing` seconds after the start of the push and moves the edge `reach` m further ahead than
/// that of the stance foot: m omega^2 T (d0 e^(omega T) + D e^(-omega (t_s - T))) / (e^(omega T) -
/// 1). Throws DefinitionError like least_peak_angular_momentum(), and if the foot lands before the
/// push ends.
double largest_impulse_with_step(double reach, double landing, const StandingPush& push);

}  // namespace saltus::robots
