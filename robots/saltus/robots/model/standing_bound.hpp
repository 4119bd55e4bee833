// Which pushes could a robot survive at best: standing on one foot, or with one step?
//
// Model: linear inverted pendulum of height z with a flywheel, pushed by the constant force J / T
// for the time T, along one axis. Coordinates along the push, from the CoM at rest (t = 0); the
// centre of pressure p reaches at most the edge of the foot, d0 ahead. The capture point obeys
//   xi' = omega (xi - p) + (F - H'/z) / (m omega),   H(0) = 0,  |H'| <= torque,
// with H the angular momentum about the CoM, counted positive in the direction that brakes.
// Multiplying by e^(-omega t) and integrating, with p at the edge throughout (any other p is
// worse) and the H' term by parts, the robot stops with its capture point on the foot and
// H(t_end) = 0 if and only if
//   J (1 - e^(-omega T)) / (m omega^2 T) - d0 <= 1/(m z) integral_0^t_end e^(-omega t) H(t) dt.
// The right side grows with H(t) at every t, so the best H for a peak value h is the largest one
// that its slope allows: H(t) = min(torque t, h, torque (t_end - t)). Everything follows in closed
// form; no controller that keeps |H| <= h on this model survives more.
#pragma once

#include "saltus/core/bounds.hpp"

namespace saltus {

/// The situation before the push.
struct StandingPush {
  double mass = 0.0;              // m, kg
  double height = 0.0;            // z of the CoM above the contact plane, m
  double distance_to_edge = 0.0;  // d0, from the CoM to the foot's edge along the push, m
  double duration = 0.1;          // T of the push, s
  double torque = infinity;       // largest |H'|, Nm
  double settle_time = 2.0;       // t_end, from the start of the push, s; not before its end
};

/// The least peak |H| (Nms) with which an impulse (N s) can be survived standing; zero when the
/// plain pendulum survives it, infinity when the torque limit makes it impossible.
/// Throws DefinitionError for values that are not positive (settle_time < duration, NaN).
double least_peak_angular_momentum(double impulse, const StandingPush& push);

/// The largest impulse (N s) that can be survived standing with |H| <= peak (Nms); peak = 0 is the
/// plain pendulum: m omega^2 T d0 / (1 - e^(-omega T)). Throws DefinitionError as above.
double largest_impulse_standing(double peak_angular_momentum, const StandingPush& push);

/// The largest impulse (N s) that the plain pendulum survives with one step: the foot lands
/// `landing` seconds after the start of the push and carries the edge `reach` m further ahead than
/// the stance foot's: m omega^2 T (d0 e^(omega T) + D e^(-omega (t_s - T))) / (e^(omega T) - 1).
/// Throws DefinitionError as above, and for a landing before the push ends.
double largest_impulse_with_step(double reach, double landing, const StandingPush& push);

}  // namespace saltus
