// What changes from tick to tick in the push recovery problem, as the parameters of its formulas.
#pragma once

#include "saltus/robots/model/support_polygon.hpp"

namespace saltus::push_recovery {

inline constexpr int hull_rows = 8;  ///< most edges of the convex hull of two rectangles
inline constexpr int tick_size = 3 + 3 + 1 + 3 + 9 + 2 + 3 * hull_rows + 1;

/// The parameter vector p with its parts named; S is the scalar of the formula.
template <class S>
struct TickView {
  explicit TickView(const Vec<S, tick_size>& p)
      : com(p.template segment<3>(0)),
        force(p.template segment<3>(3)),
        omega(p[6]),
        swing_foot(p.template segment<3>(7)),
        gamma_desired(p.template segment<9>(10)),
        capture_point_desired(p.template segment<2>(19)),
        hull_offsets(p.template segment<hull_rows>(21 + 2 * hull_rows)),
        standing(p[21 + 3 * hull_rows]) {
    for (int i = 0; i < hull_rows; ++i)
      hull_normals.row(i) = p.template segment<2>(21 + 2 * i).transpose();
  }

  Vec<S, 3> com;         ///< x_CoM^0 of the last measurement, m
  Vec<S, 3> force;       ///< sum of the contact forces applied last, world axes, N
  S omega;               ///< sqrt(g / z) with the CoM height measured, 1/s
  Vec<S, 3> swing_foot;  ///< contact frame of the swing foot once landed, m
  Vec<S, 9> gamma_desired;
  Vec<S, 2> capture_point_desired;  ///< m
  Mat<S, hull_rows, 2> hull_normals;
  Vec<S, hull_rows> hull_offsets;  ///< hull = {x : normals x <= offsets}, m
  S standing;                      ///< 1 while no step is planned, else 0
};

/// The same parts as numbers.
struct TickData {
  Vec<double, 3> com = Vec<double, 3>::Zero();
  Vec<double, 3> force = Vec<double, 3>::Zero();
  double omega = 4.3;
  Vec<double, 3> swing_foot = Vec<double, 3>::Zero();
  Vec<double, 9> gamma_desired = Vec<double, 9>::Zero();
  Vec<double, 2> capture_point_desired = Vec<double, 2>::Zero();
  HalfPlanes hull;  ///< hull_rows rows
  double standing = 0.0;

  Vec<double, tick_size> vector() const {
    Vec<double, tick_size> p;
    p << com, force, omega, swing_foot, gamma_desired, capture_point_desired,
        Vec<double, 3 * hull_rows>::Zero(), standing;
    for (int i = 0; i < hull_rows; ++i) {
      p.segment<2>(21 + 2 * i) = hull.A.row(i).transpose();
      p[21 + 2 * hull_rows + i] = hull.b[i];
    }
    return p;
  }
};

}  // namespace saltus::push_recovery
