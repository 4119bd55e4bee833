// The quadratic program of the push recovery problem, built from its equations.
//
// An independent derivation for tests, without code from framework, robots or problems.
// State x = (CoM, velocity, angular momentum), input f = (left wrench, right wrench), world axes:
//   x' = A x + B f + c,  A^3 = 0, so over an interval of length h exactly
//   x(h) = (I + h A + h^2/2 A^2) x + E (B f + c),  E = h I + h^2/2 A + h^3/6 A^2.
// Nodes at the multiples of dt and at the impact; costs of node k weighted with h_k:
//   sum_k h_k/2 (|x_k - x_d|^2_Kg + |f_k|^2_Kf + [t_k >= t_impact] (|x_k - x_d|^2_Ki
//     + |xi_k - xi_d|^2_Kc)) + 1/2 |x_N - x_d|^2_Ki,  xi = capture point,
// and on request for the wrenches of feet that stand in both intervals, with h_(-1) = dt:
//   sum_k wrench_change/2 dt / ((h_(k-1) + h_k) / 2) |f_k - f_(k-1)|^2.
#pragma once

#include <vector>

#include "tests/problems/dense_qp.hpp"

namespace saltus::testing {

/// Flat feet without rotation; four circumscribed friction edges. SI units. The defaults are the
/// data of instance ICUB-1.
struct StepRecovery {
  double mass = 30.0, gravity = 9.81;
  Vec<double, 3> left_foot{0.0, 0.07, 0.0}, right_foot{0.0, -0.12, 0.0};
  Vec<double, 3> com{0.01, 0.02, 0.5}, velocity{0.0, -0.35, 0.0};
  Vec<double, 3> force{0.0, 0.0, 294.3};  ///< sum of the contact forces before the horizon
  double step = 0.01;
  int intervals = 15;
  double impact = 0.06;
  Vec<double, 3> com_desired{0.0, -0.025, 0.5};  ///< everything else of x_d is zero
  Vec<double, 3> com_weight{0.0, 0.0, 100.0}, velocity_weight{0.0, 0.0, 10.0};
  double momentum_weight = 1.0;
  double com_impact_weight = 1000.0, velocity_impact_weight = 10.0, momentum_impact_weight = 1.0;
  Vec<double, 3> force_weight{0.001, 0.001, 0.0001};  ///< force of each foot
  double torque_weight = 0.01;
  double wrench_change = 0.0;  ///< the left wrench before the horizon is `force` without torque
  double capture_point_weight = 1000.0;  ///< about (x, y) of com_desired
  double friction = 1.0 / 3.0, torsion = 1.0 / 75.0, normal_min = 10.0;
  Vec<double, 2> foot_x{-0.05, 0.1}, foot_y{-0.03, 0.03};
  Vec<double, 2> hull_x{-0.05, 0.1}, hull_y{-0.15, 0.1};
};

/// The program and the positions of its parts in z = (x_0, .., x_N, f_0, .., f_(N-1)).
struct DenseStepRecovery {
  DenseQp qp;
  std::vector<double> times;  ///< times of the nodes
  /// Per node the first of its four capture point rows (x max, x min, y max, y min), or -1.
  std::vector<int> hull_row;

  int nodes() const { return static_cast<int>(times.size()); }
  int state(int node) const { return 9 * node; }
  int input(int interval) const { return 9 * nodes() + 12 * interval; }
};

DenseStepRecovery build(const StepRecovery& instance);

}  // namespace saltus::testing
