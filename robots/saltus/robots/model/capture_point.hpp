// Linear inverted pendulum, its capture point and capturability margins.
//
// Pendulum of constant height z: x'' = omega^2 (x - p), omega = sqrt(g / z), where p is the centre
// of pressure. The instantaneous capture point xi = x + v / omega obeys xi' = omega (xi - p): it
// diverges from p (Pratt et al. 2006; Koolen et al. 2012). The functions are templates over the
// scalar, for use inside formulas. Positions in m, speeds in m/s, times in s.
#pragma once

#include <cmath>

#include "saltus/core/types.hpp"

namespace saltus::robots {

/// m/s^2: the value of the published cases and the default of the simulators (not 9.80665).
inline constexpr double standard_gravity = 9.81;

/// Natural frequency omega in 1/s, from the height of the CoM above the ground (m).
template <class S>
S pendulum_frequency(const S& height, double gravity = standard_gravity) {
  using std::sqrt;
  return sqrt(S(gravity) / height);
}

/// Instantaneous capture point x + v / omega, for one axis or on the ground. `position` and
/// `velocity` are numbers or vectors of the same size.
template <class S>
S capture_point(const S& position, const S& velocity, const S& omega) {
  return position + velocity / omega;
}
/// Instantaneous capture point for vectors, m; omega in 1/s.
template <class S, int n>
Vec<S, n> capture_point(const Vec<S, n>& position, const Vec<S, n>& velocity, const S& omega) {
  return position + velocity / omega;
}

/// The capture point after the angular momentum H about the CoM (Nms) has returned to zero. While
/// the flywheel stops, it moves the CoM by m z dv = (-dH_y, dH_x), which cancels the effect of
/// spinning up. The height z above the ground follows from omega and is independent of the height
/// of the ground in the world.
inline Vec<double, 2> capture_point_at_rest(const Vec<double, 3>& com,
                                            const Vec<double, 3>& velocity,
                                            const Vec<double, 3>& angular_momentum, double mass,
                                            double omega) {
  const Vec<double, 2> lent(-angular_momentum[1], angular_momentum[0]);
  const double height = standard_gravity / (omega * omega);
  return com.head<2>() + (velocity.head<2>() - lent / (mass * height)) / omega;
}

/// Capture point after the time t with constant centre of pressure: p + (xi - p) e^(omega t).
template <class S>
S propagate_capture_point(const S& xi, const S& centre_of_pressure, const S& omega, const S& t) {
  using std::exp;
  return centre_of_pressure + (xi - centre_of_pressure) * exp(omega * t);
}
/// Capture point after t seconds with constant centre of pressure, for vectors, m.
template <class S, int n>
Vec<S, n> propagate_capture_point(const Vec<S, n>& xi, const Vec<S, n>& centre_of_pressure,
                                  const S& omega, const S& t) {
  using std::exp;
  return centre_of_pressure + (xi - centre_of_pressure) * exp(omega * t);
}

/// Position and speed of the pendulum along one axis.
template <class S>
struct PendulumState {
  S position;  // m
  S velocity;  // m/s
};

/// State of the pendulum after the time t with constant centre of pressure.
template <class S>
PendulumState<S> propagate_pendulum(const PendulumState<S>& start, const S& centre_of_pressure,
                                    const S& omega, const S& t) {
  using std::exp;
  const S grow = exp(omega * t);
  const S c = 0.5 * (grow + 1.0 / grow);
  const S s = 0.5 * (grow - 1.0 / grow);
  const S x = start.position - centre_of_pressure;
  return {centre_of_pressure + x * c + start.velocity / omega * s,
          x * omega * s + start.velocity * c};
}

/// Orbital energy per mass (m^2/s^2), conserved while p is constant. If the CoM moves towards p, a
/// negative value means that it turns back before p, a positive value that it passes p, and zero
/// that it comes to rest above p.
template <class S>
S orbital_energy(const PendulumState<S>& state, const S& centre_of_pressure, const S& omega) {
  const S x = state.position - centre_of_pressure;
  return 0.5 * state.velocity * state.velocity - 0.5 * omega * omega * x * x;
}

/// Limits of the steps of a walker (Koolen et al. 2012).
struct StepLimits {
  double longest_step = 0.4;   // l, m, from ankle to ankle
  double shortest_time = 0.3;  // t_s, s, for one step
  double foot_radius = 0.0;    // r, m: how far the centre of pressure may move from the ankle
};

/// N-step capturability margin d_N (m): the walker can stop within N steps if |xi - p0| <= d_N. d_0
/// = r, d_N = (l - r + d_(N-1)) e^(-omega t_s) + r.
inline double capturability_margin(int steps, const StepLimits& limits, double omega) {
  const double shrink = std::exp(-omega * limits.shortest_time);
  double margin = limits.foot_radius;
  for (int i = 0; i < steps; ++i)
    margin = (limits.longest_step - limits.foot_radius + margin) * shrink + limits.foot_radius;
  return margin;
}

/// The limit of d_N for many steps: ((l - r) e^(-omega t_s) + r) / (1 - e^(-omega t_s)).
inline double capturability_limit(const StepLimits& limits, double omega) {
  const double shrink = std::exp(-omega * limits.shortest_time);
  return ((limits.longest_step - limits.foot_radius) * shrink + limits.foot_radius) /
         (1.0 - shrink);
}

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
template <class S>
using PendulumState [[deprecated("use robots::PendulumState; removed in 0.4")]] =
    robots::PendulumState<S>;
/// Deprecated name.
using StepLimits [[deprecated("use robots::StepLimits; removed in 0.4")]] = robots::StepLimits;
using robots::capturability_limit;      ///< deprecated name
using robots::capturability_margin;     ///< deprecated name
using robots::capture_point;            ///< deprecated name
using robots::capture_point_at_rest;    ///< deprecated name
using robots::orbital_energy;           ///< deprecated name
using robots::pendulum_frequency;       ///< deprecated name
using robots::propagate_capture_point;  ///< deprecated name
using robots::propagate_pendulum;       ///< deprecated name
using robots::standard_gravity;         ///< deprecated name
}  // namespace saltus
