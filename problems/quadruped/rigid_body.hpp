// A rigid body under the forces of its feet: the model of the plan, and the body of the plant.
//
// State x = (position of the CoM m, velocity m/s, roll, pitch, yaw rad, angular velocity rad/s);
// all in world axes except the angular velocity, which is in body axes. R = Rz(yaw) Ry(pitch)
// Rx(roll) maps body axes to world axes. The legs have no mass.
#pragma once

#include "saltus/autodiff/math.hpp"
#include "saltus/core/types.hpp"

namespace saltus::quadruped {

inline constexpr int legs = 4;  // FL, FR, RL, RR: front and rear, left and right
inline constexpr const char* leg_names[legs] = {"FL", "FR", "RL", "RR"};
inline constexpr int states = 12;
inline constexpr double gravity = 9.81;  // m/s^2

template <class S>
using State = Vec<S, states>;
template <class S>
using PerLeg = Mat<S, 3, legs>;  // one column per leg: positions (m) or forces (N), world axes

struct Body {
  double mass = 12.0;                         // kg
  Vec<double, 3> inertia{0.07, 0.26, 0.242};  // about the body axes, kg m^2

  Vec<double, 3> hip(int leg) const {  // from the CoM, body axes, m
    return {leg < 2 ? 0.19 : -0.19, leg % 2 == 0 ? 0.11 : -0.11, 0.0};
  }
};

template <class S>
Mat<S, 3, 3> rotation(const State<S>& x) {
  const S cr = cos(x[6]), sr = sin(x[6]), cp = cos(x[7]), sp = sin(x[7]), cy = cos(x[8]),
          sy = sin(x[8]);
  Mat<S, 3, 3> R;
  R << cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr,  //
      sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr,   //
      -sp, cp * sr, cp * cr;
  return R;
}

/// x' of a body under a force and a torque about its CoM, both in world axes (N, Nm):
///   p' = v,   v' = force / m - g e_z,   angles' = E(angles) w,   I w' = R' torque - w x I w.
template <class S>
State<S> rate(const Body& body, const State<S>& x, const Vec<S, 3>& force,
              const Vec<S, 3>& torque) {
  const Vec<S, 3> w = x.template tail<3>(), inertia = body.inertia.template cast<S>();
  const S cr = cos(x[6]), sr = sin(x[6]), yaw_rate = (w[1] * sr + w[2] * cr) / cos(x[7]);
  const Vec<S, 3> momentum = inertia.cwiseProduct(w);
  const Vec<S, 3> about_axes = rotation(x).transpose() * torque - w.cross(momentum);
  State<S> dx;
  dx << x.template segment<3>(3),
      force * S(1.0 / body.mass) - Vec<S, 3>(S(0.0), S(0.0), S(gravity)),
      w[0] + sin(x[7]) * yaw_rate, w[1] * cr - w[2] * sr, yaw_rate, about_axes[0] / inertia[0],
      about_axes[1] / inertia[1], about_axes[2] / inertia[2];
  return dx;
}

/// x' of a body under the forces of its feet.
template <class S>
State<S> rate(const Body& body, const State<S>& x, const PerLeg<S>& feet, const PerLeg<S>& forces) {
  Vec<S, 3> force = Vec<S, 3>::Zero(), torque = Vec<S, 3>::Zero();
  for (int leg = 0; leg < legs; ++leg) {
    const Vec<S, 3> arm = feet.col(leg) - x.template head<3>(), push = forces.col(leg);
    force += push;
    torque += arm.cross(push);
  }
  return rate(body, x, force, torque);
}

}  // namespace saltus::quadruped
