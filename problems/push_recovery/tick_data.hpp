// Data that change from tick to tick, as the parameters of the formulas.
#pragma once

#include "saltus/model/named_parameters.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus::push_recovery {

/// Most edges of the convex hull of two rectangles.
inline constexpr int hull_rows = robots::SupportOfTwoFeet::rows;

template <class S>
struct Tick {
  Vec<S, 3> com = Vec<S, 3>::Zero();    ///< x_CoM^0 of the last measurement, m
  Vec<S, 3> force = Vec<S, 3>::Zero();  ///< sum of the contact forces applied last, world, N
  S omega = 4.3;                        ///< sqrt(g / z) with the CoM height measured, 1/s
  /// Present or future positions of the contact frames, m.
  Vec<S, 3> left_foot = Vec<S, 3>::Zero(), right_foot = Vec<S, 3>::Zero();
  /// Directions of their x axes, which are level.
  Vec<S, 2> left_heading{1.0, 0.0}, right_heading{1.0, 0.0};
  Vec<S, 9> gamma_desired = Vec<S, 9>::Zero();
  Vec<S, 2> capture_point_desired = Vec<S, 2>::Zero();  ///< m
  /// hull = {x : normals x <= offsets}, m
  Mat<S, hull_rows, 2> hull_normals = Mat<S, hull_rows, 2>::Zero();
  Vec<S, hull_rows> hull_offsets = Vec<S, hull_rows>::Zero();
  /// Ends of the supported parts of the soles: x, y, each lower and upper, sole frame, m.
  Vec<S, 4> left_support = Vec<S, 4>::Zero(), right_support = Vec<S, 4>::Zero();
  S standing = 0.0;   ///< 1 while no step is planned, else 0
  S following = 0.0;  ///< 1 while steps follow a task, else 0
  // Planned motion (m) as coefficients of polynomials of the time since `motion_begin` (s,
  // absolute), constant first. Without a task, the constant is the target.
  S motion_begin = 0.0;
  Mat<S, 2, 3> com_motion = Mat<S, 2, 3>::Zero(), capture_motion = Mat<S, 2, 3>::Zero();

  using Entries =
      ParameterEntries<&Tick::com, &Tick::force, &Tick::omega, &Tick::left_foot, &Tick::right_foot,
                       &Tick::left_heading, &Tick::right_heading, &Tick::gamma_desired,
                       &Tick::capture_point_desired, &Tick::hull_normals, &Tick::hull_offsets,
                       &Tick::left_support, &Tick::right_support, &Tick::standing, &Tick::following,
                       &Tick::motion_begin, &Tick::com_motion, &Tick::capture_motion>;

  void set_hull(const robots::SupportPolygon::HalfPlanes& hull) {  // hull_rows rows
    hull_normals = hull.A;
    hull_offsets = hull.b;
  }
};

}  // namespace saltus::push_recovery
