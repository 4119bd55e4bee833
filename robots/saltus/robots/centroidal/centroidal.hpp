// Effect of contact wrenches on the centre of mass and on the angular momentum about it.
//
// State gamma = (x, v, H): CoM position (m) and velocity (m/s), angular momentum about the CoM
// (kg m^2/s), all in the world's axes, z up. With contact i at x_i exerting the force f_i and the
// torque tau_i about x_i (world axes):
//   x' = v
//   v' = sum_i f_i / m + (0, 0, -g) + (external force) / m
//   H' = sum_i tau_i + (x_i - x) x f_i                                     exact, bilinear
//   H' = sum_i tau_i + (x_i - x0) x f_i + (sum_i f_i0) x (x - x0)          linearised about x0,
//   f_i0
// The linearised form is Dafarra, Romano, Nori, "A receding horizon push recovery strategy for
// balancing the iCub humanoid robot", equations of the section "The model": the difference to the
// exact one is -(x - x0) x sum_i (f_i - f_i0).
#pragma once

#include <Eigen/Geometry>
#include <array>
#include <cstddef>

#include "saltus/core/types.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus::robots {

/// The state vector of the centroidal model with its parts named.
template <class S>
struct CentroidalState {
  Vec<S, 3> com;               // m
  Vec<S, 3> velocity;          // m/s
  Vec<S, 3> angular_momentum;  // about the CoM, kg m^2/s

  /// Constructs the state from its parts.
  CentroidalState(const Vec<S, 3>& x, const Vec<S, 3>& v, const Vec<S, 3>& h)
      : com(x), velocity(v), angular_momentum(h) {}
  /// Constructs the state from gamma = (com, velocity, angular momentum).
  explicit CentroidalState(const Vec<S, 9>& gamma)
      : com(gamma.template segment<3>(0)),
        velocity(gamma.template segment<3>(3)),
        angular_momentum(gamma.template segment<3>(6)) {}
  /// gamma = (com, velocity, angular momentum).
  Vec<S, 9> vector() const {
    Vec<S, 9> gamma;
    gamma << com, velocity, angular_momentum;
    return gamma;
  }
};

/// A contact wrench in world axes.
template <class S>
struct Contact {
  Vec<S, 3> position;  // x_i: of the sole frame's origin, m
  Vec<S, 3> force;     // f_i, N
  Vec<S, 3> torque;    // tau_i about x_i, Nm
};

/// Converts the wrench (fx, fy, fz, tx, ty, tz) in the axes of the sole (see contact_cone.hpp) to a
/// contact. P is double for a foothold known at set-up, S for one that is a parameter or an
/// unknown.
template <class S, class P>
Contact<S> contact(const SoleFrameOf<P>& sole, const Vec<S, 6>& wrench) {
  const Vec<S, 3> force = wrench.template head<3>();
  const Vec<S, 3> torque = wrench.template tail<3>();
  return {sole.position.template cast<S>(), sole.to_world(force), sole.to_world(torque)};
}

/// Expansion point for the angular momentum: the last measurement, in world axes. Pass it as
/// parameters (with the formula's scalar S) if it changes between solves. As constants, the zeros
/// of the first measurement would enter the sparsity pattern.
template <class S>
struct ExpansionPoint {
  Vec<S, 3> com;    // x0, m
  Vec<S, 3> force;  // sum over the contacts of f_i0, N
};

/// H', exact.
template <class S, std::size_t n>
Vec<S, 3> angular_momentum_rate(const Vec<S, 3>& com, const std::array<Contact<S>, n>& contacts) {
  Vec<S, 3> rate(S(0.0), S(0.0), S(0.0));
  for (const Contact<S>& c : contacts) rate += c.torque + (c.position - com).cross(c.force);
  return rate;
}

/// H' to first order about the expansion point; P is double or S.
template <class S, class P, std::size_t n>
Vec<S, 3> angular_momentum_rate(const Vec<S, 3>& com, const std::array<Contact<S>, n>& contacts,
                                const ExpansionPoint<P>& about) {
  const Vec<S, 3> com_0 = about.com.template cast<S>();
  const Vec<S, 3> force_0 = about.force.template cast<S>();
  Vec<S, 3> rate = force_0.cross(com - com_0);
  for (const Contact<S>& c : contacts) rate += c.torque + (c.position - com_0).cross(c.force);
  return rate;
}

/// v' in m/s^2; `external_force` acts on the CoM (a push), N; P is
/// double or S.
template <class S, std::size_t n, class P = double>
Vec<S, 3> com_acceleration(double mass, const std::array<Contact<S>, n>& contacts,
                           const Vec<P, 3>& external_force = Vec<double, 3>(0.0, 0.0, 0.0)) {
  Vec<S, 3> acceleration;
  for (int axis = 0; axis < 3; ++axis) {
    S force(external_force[axis]);
    for (const Contact<S>& c : contacts) force = force + c.force[axis];
    acceleration[axis] = force * (1.0 / mass);
  }
  acceleration[2] = acceleration[2] - standard_gravity;
  return acceleration;
}

/// gamma', exact; integrated by the centroidal plant.
template <class S, std::size_t n, class P = double>
Vec<S, 9> centroidal_dynamics(double mass, const Vec<S, 9>& gamma,
                              const std::array<Contact<S>, n>& contacts,
                              const Vec<P, 3>& external_force = Vec<double, 3>(0.0, 0.0, 0.0)) {
  const CentroidalState<S> state(gamma);
  return CentroidalState<S>(state.velocity, com_acceleration(mass, contacts, external_force),
                            angular_momentum_rate(state.com, contacts))
      .vector();
}

/// gamma' with the angular momentum linearised: affine in (gamma, wrenches), the prediction model
/// of the paper's controller.
template <class S, class P, std::size_t n>
Vec<S, 9> linearised_centroidal_dynamics(double mass, const Vec<S, 9>& gamma,
                                         const std::array<Contact<S>, n>& contacts,
                                         const ExpansionPoint<P>& about) {
  const CentroidalState<S> state(gamma);
  return CentroidalState<S>(state.velocity, com_acceleration(mass, contacts),
                            angular_momentum_rate(state.com, contacts, about))
      .vector();
}

}  // namespace saltus::robots

namespace saltus {  // deprecated names, removed in 0.4
/// Deprecated name.
template <class S>
using CentroidalState [[deprecated("use robots::CentroidalState; removed in 0.4")]] =
    robots::CentroidalState<S>;
/// Deprecated name.
template <class S>
using Contact [[deprecated("use robots::Contact; removed in 0.4")]] = robots::Contact<S>;
/// Deprecated name.
template <class S>
using ExpansionPoint [[deprecated("use robots::ExpansionPoint; removed in 0.4")]] =
    robots::ExpansionPoint<S>;
using robots::angular_momentum_rate;           ///< deprecated name
using robots::centroidal_dynamics;             ///< deprecated name
using robots::com_acceleration;                ///< deprecated name
using robots::contact;                         ///< deprecated name
using robots::linearised_centroidal_dynamics;  ///< deprecated name
}  // namespace saltus
