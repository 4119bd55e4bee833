#include "tests/problems/dense_step_recovery.hpp"

#include <cmath>

#include "saltus/core/types.hpp"

namespace saltus::testing {
namespace {

using Matrix9 = Mat<double, 9, 9>;

// Collects rows one by one.
struct Rows {
  explicit Rows(Eigen::Index columns) : matrix(0, columns) {}
  MatrixXd matrix;
  VectorXd right;

  Eigen::Index add(Eigen::Index count) {
    const Eigen::Index first = matrix.rows();
    matrix.conservativeResize(first + count, Eigen::NoChange);
    matrix.bottomRows(count).setZero();
    right.conservativeResize(first + count);
    right.tail(count).setZero();
    return first;
  }
};

std::vector<double> node_times(const StepRecovery& s) {
  std::vector<double> times;
  constexpr double same = 1e-9;  // s: the tests place the impact on a node or far from all
  for (int k = 0; k <= s.intervals; ++k) {
    const double t = k * s.step;
    if (!times.empty() && s.impact > times.back() + same && s.impact < t - same)
      times.push_back(s.impact);
    times.push_back(t);
  }
  return times;
}

// 11 rows per foot: friction, torsion, centre of pressure, least normal force.
Mat<double, 11, 6> cone(const StepRecovery& s) {
  Mat<double, 11, 6> rows = Mat<double, 11, 6>::Zero();
  for (int i = 0; i < 4; ++i) {
    rows(i, i / 2) = i % 2 == 0 ? 1.0 : -1.0;
    rows(i, 2) = -s.friction;
  }
  rows(4, 5) = 1.0, rows(4, 2) = -s.torsion;
  rows(5, 5) = -1.0, rows(5, 2) = -s.torsion;
  rows(6, 4) = 1.0, rows(6, 2) = s.foot_x[0];    // -ty/fz >= x min
  rows(7, 4) = -1.0, rows(7, 2) = -s.foot_x[1];  // -ty/fz <= x max
  rows(8, 3) = -1.0, rows(8, 2) = s.foot_y[0];   // tx/fz >= y min
  rows(9, 3) = 1.0, rows(9, 2) = -s.foot_y[1];   // tx/fz <= y max
  rows(10, 2) = -1.0;
  return rows;
}

}  // namespace

DenseStepRecovery build(const StepRecovery& s) {
  DenseStepRecovery result;
  result.times = node_times(s);
  const int nodes = result.nodes(), intervals = nodes - 1;
  const Eigen::Index n = 9 * nodes + 12 * intervals;
  constexpr double same = 1e-9;
  const auto landed = [&](int node) { return result.times[node] > s.impact - same; };

  // Dynamics: the torque due to CoM motion uses the force before the horizon.
  Matrix9 A = Matrix9::Zero();
  A.block<3, 3>(0, 3).setIdentity();
  A.block<3, 3>(6, 0) = skew<double>(s.force);
  Mat<double, 9, 12> B = Mat<double, 9, 12>::Zero();
  int column = 0;
  for (const Vec<double, 3>& foot : {s.left_foot, s.right_foot}) {
    B.block<3, 3>(3, column) = Mat<double, 3, 3>::Identity() / s.mass;
    B.block<3, 3>(6, column) = skew<double>(foot - s.com);
    B.block<3, 3>(6, column + 3).setIdentity();
    column += 6;
  }
  Vec<double, 9> c = Vec<double, 9>::Zero();
  c[5] = -s.gravity;
  c.tail<3>() = -skew<double>(s.force) * s.com;

  Vec<double, 9> desired = Vec<double, 9>::Zero();
  desired.head<3>() = s.com_desired;
  Vec<double, 9> weight, impact_weight;
  weight << s.com_weight, s.velocity_weight, Vec<double, 3>::Constant(s.momentum_weight);
  impact_weight << Vec<double, 3>::Constant(s.com_impact_weight),
      Vec<double, 3>::Constant(s.velocity_impact_weight),
      Vec<double, 3>::Constant(s.momentum_impact_weight);
  Vec<double, 12> wrench_weight;
  const Vec<double, 3> torque_weight = Vec<double, 3>::Constant(s.torque_weight);
  wrench_weight << s.force_weight, torque_weight, s.force_weight, torque_weight;

  Mat<double, 2, 9> capture = Mat<double, 2, 9>::Zero();
  const double omega = std::sqrt(s.gravity / s.com[2]);
  capture(0, 0) = capture(1, 1) = 1.0;
  capture(0, 3) = capture(1, 4) = 1.0 / omega;

  DenseQp& qp = result.qp;
  qp.P = MatrixXd::Zero(n, n);
  qp.q = VectorXd::Zero(n);
  qp.scale.resize(n);
  qp.scale << VectorXd::Constant(9 * nodes, 0.1), VectorXd::Constant(12 * intervals, 10.0);
  const auto pay = [&](int first, const MatrixXd& J, const VectorXd& W, const VectorXd& target) {
    const Eigen::Index size = J.cols();
    qp.P.block(first, first, size, size) += J.transpose() * W.asDiagonal() * J;
    qp.q.segment(first, size) -= J.transpose() * W.cwiseProduct(target);
    qp.constant += 0.5 * target.dot(W.cwiseProduct(target));
  };
  const MatrixXd whole = MatrixXd::Identity(9, 9);
  for (int k = 0; k < intervals; ++k) {
    const double h = result.times[k + 1] - result.times[k];
    pay(result.state(k), whole, h * weight, desired);
    pay(result.input(k), MatrixXd::Identity(12, 12), h * wrench_weight, VectorXd::Zero(12));
    if (!landed(k)) continue;
    pay(result.state(k), whole, h * impact_weight, desired);
    pay(result.state(k), capture, VectorXd::Constant(2, h * s.capture_point_weight),
        desired.head<2>());
  }
  pay(result.state(intervals), whole, impact_weight, desired);

  // Differences of wrenches: left ones throughout, right ones between intervals after the impact.
  Vec<double, 6> before = Vec<double, 6>::Zero();
  before.head<3>() = s.force;
  const double first_length = 0.5 * (s.step + result.times[1]);
  if (s.wrench_change > 0.0)
    pay(result.input(0), MatrixXd::Identity(6, 6),
        VectorXd::Constant(6, s.wrench_change * s.step / first_length), before);
  for (int k = 1; k < intervals; ++k) {
    const double length = 0.5 * (result.times[k + 1] - result.times[k - 1]);
    const double per_change = s.wrench_change * s.step / length;
    const int entries = landed(k - 1) ? 12 : 6;
    for (int i = 0; i < entries; ++i) {
      const int a = result.input(k - 1) + i, b = result.input(k) + i;
      qp.P(a, a) += per_change, qp.P(b, b) += per_change;
      qp.P(a, b) -= per_change, qp.P(b, a) -= per_change;
    }
  }

  Rows equal(n), limit(n);
  const Eigen::Index start = equal.add(9);
  equal.matrix.block(start, 0, 9, 9).setIdentity();
  equal.right.segment<3>(start) = s.com;
  equal.right.segment<3>(start + 3) = s.velocity;
  const Mat<double, 11, 6> wrench_rows = cone(s);
  for (int k = 0; k < intervals; ++k) {
    const double h = result.times[k + 1] - result.times[k];
    const Matrix9 A2 = A * A;
    const Matrix9 transition = Matrix9::Identity() + h * A + 0.5 * h * h * A2;
    const Matrix9 E = h * Matrix9::Identity() + 0.5 * h * h * A + h * h * h / 6.0 * A2;
    const Eigen::Index row = equal.add(9);
    equal.matrix.block(row, result.state(k + 1), 9, 9).setIdentity();
    equal.matrix.block(row, result.state(k), 9, 9) = -transition;
    equal.matrix.block(row, result.input(k), 9, 12) = -E * B;
    equal.right.segment(row, 9) = E * c;
    if (!landed(k)) {
      const Eigen::Index none = equal.add(6);
      equal.matrix.block(none, result.input(k) + 6, 6, 6).setIdentity();
    }
    for (int foot = 0; foot < (landed(k) ? 2 : 1); ++foot) {
      const Eigen::Index first = limit.add(11);
      limit.matrix.block(first, result.input(k) + 6 * foot, 11, 6) = wrench_rows;
      limit.right[first + 10] = -s.normal_min;
    }
  }
  for (int node = 0; node < nodes; ++node) {
    result.hull_row.push_back(-1);
    if (node == 0 || !landed(node)) continue;
    const Eigen::Index first = limit.add(4);
    Mat<double, 4, 2> normals;
    normals << 1.0, 0.0, -1.0, 0.0, 0.0, 1.0, 0.0, -1.0;
    limit.matrix.block(first, result.state(node), 4, 9) = normals * capture;
    limit.right.segment(first, 4) << s.hull_x[1], -s.hull_x[0], s.hull_y[1], -s.hull_y[0];
    result.hull_row.back() = static_cast<int>(first);
  }
  qp.A = std::move(equal.matrix);
  qp.b = std::move(equal.right);
  qp.G = std::move(limit.matrix);
  qp.h = std::move(limit.right);
  return result;
}

}  // namespace saltus::testing
