// Rotation vectors: exp and log of SO(3), and the left Jacobian of exp.
#pragma once

#include <Eigen/Geometry>
#include <cmath>

#include "saltus/core/types.hpp"

namespace saltus::robots {

/// exp of SO(3): the rotation by |v| rad about v.
inline Mat<double, 3, 3> exp_so3(const Vec<double, 3>& v) {
  const double angle = v.norm();
  if (angle == 0.0) return Mat<double, 3, 3>::Identity();
  return Eigen::AngleAxisd(angle, v / angle).toRotationMatrix();
}

/// log of SO(3): the rotation vector, with |v| in [0, pi].
inline Vec<double, 3> log_so3(const Mat<double, 3, 3>& R) {
  const Eigen::AngleAxisd turn(R);
  return turn.angle() * turn.axis();
}

/// Left Jacobian J: exp(v + dv) = exp(J dv) exp(v) to first order.
inline Mat<double, 3, 3> left_jacobian(const Vec<double, 3>& v) {
  const double a = v.norm();
  // rad; below it the series has a relative error of at most a^3 / 120
  constexpr double small = 1e-4;
  const double first = a < small ? 0.5 - a * a / 24.0 : (1.0 - std::cos(a)) / (a * a);
  const double second = a < small ? 1.0 / 6.0 - a * a / 120.0 : (a - std::sin(a)) / (a * a * a);
  const Mat<double, 3, 3> S = skew<double>(v);
  return Mat<double, 3, 3>::Identity() + first * S + second * S * S;
}

}  // namespace saltus::robots
