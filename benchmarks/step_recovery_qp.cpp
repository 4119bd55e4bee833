#include "benchmarks/step_recovery_qp.hpp"

#include <cmath>
#include <numbers>

#include "saltus/core/random.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus::bench {
namespace {

constexpr double gravity = 9.81, height = 0.53;  // m/s^2, m
constexpr double mass = StepRecovery::mass, dt = StepRecovery::tick;
constexpr double force_unit = StepRecovery::force_unit, torque_unit = StepRecovery::torque_unit;
constexpr int cone_rows = 15;
using Matrix9 = Mat<double, 9, 9>;
using Matrix96 = Mat<double, 9, 6>;
const Vec<double, 3> left_foot(StepRecovery::left_foot.data());
const Vec<double, 3> right_foot(StepRecovery::right_foot.data());
const robots::FootRectangle sole{between(-0.07, 0.10), between(-0.03, 0.03)};

Mat<double, 3, 3> cross_matrix(const Vec<double, 3>& a) {
  Mat<double, 3, 3> m;
  m << 0, -a[2], a[1], a[2], 0, -a[0], -a[1], a[0], 0;
  return m;
}

// Friction (8 edges), centre of pressure, torsion, minimum normal force: rows <= limits.
void cone(MatrixXd& rows, VectorXd& limits) {
  constexpr double friction = 0.4, least_force = 10.0;
  Mat<double, cone_rows, 6> C = Mat<double, cone_rows, 6>::Zero();
  VectorXd upper = VectorXd::Zero(cone_rows);
  for (int i = 0; i < 8; ++i) {
    const double angle = i * std::numbers::pi / 4.0;
    C(i, 0) = std::cos(angle);
    C(i, 1) = std::sin(angle);
    C(i, 2) = -friction * std::cos(std::numbers::pi / 8.0);
  }
  const auto limit_torque = [&](int row, int axis, double sign, double arm) {
    C(row, 3 + axis) = sign;
    C(row, 2) = -arm;
  };
  limit_torque(8, 0, 1.0, 0.03);
  limit_torque(9, 0, -1.0, 0.03);
  limit_torque(10, 1, -1.0, 0.10);
  limit_torque(11, 1, 1.0, 0.07);
  limit_torque(12, 2, 1.0, 1.0 / 75.0);
  limit_torque(13, 2, -1.0, 1.0 / 75.0);
  C(14, 2) = -1.0;
  upper[14] = -least_force;
  Vec<double, 6> unit;
  unit << Vec<double, 3>::Constant(force_unit), Vec<double, 3>::Constant(torque_unit);
  rows = C * unit.asDiagonal();
  limits = upper;
}

}  // namespace

CentroidalState nominal_start() {
  CentroidalState x;
  x << 0.015, 0.07, 0.53, 0.05, -0.25, 0.0, 0.2, 0.1, 0.0;
  return x;
}

CentroidalState random_start(std::uint64_t seed, const Bounds& push) {
  Random random(seed);
  CentroidalState x = nominal_start();
  const double speed = random.uniform(push.lower, push.upper), angle = random.uniform(-0.4, 0.4);
  const double within[3] = {0.010, 0.005, 0.005}, momentum[3] = {0.4, 0.4, 0.1};
  for (int i = 0; i < 3; ++i) x[i] += random.uniform(-within[i], within[i]);
  x[3] = speed * std::sin(angle);
  x[4] = -speed * std::cos(angle);
  x[5] = 0.0;
  for (int i = 0; i < 3; ++i) x[6 + i] = random.uniform(-momentum[i], momentum[i]);
  return x;
}

qp::StageQp step_recovery_qp(const StepRecovery& options, const CentroidalState& start) {
  const double omega = std::sqrt(gravity / height);
  const Vec<double, 3> com = start.head<3>(), weight(0.0, 0.0, mass * gravity);
  // gamma' = Ac gamma + Bc f + c, Ac^3 = 0: the zero-order hold is a polynomial.
  Matrix9 Ac = Matrix9::Zero();
  Ac.block<3, 3>(0, 3).setIdentity();
  Ac.block<3, 3>(6, 0) = cross_matrix(weight);
  CentroidalState c = CentroidalState::Zero();
  c[5] = -gravity;
  c.tail<3>() = -cross_matrix(weight) * com;
  const auto input_matrix = [&](const Vec<double, 3>& foot) {
    Matrix96 B = Matrix96::Zero();
    B.block<3, 3>(3, 0) = Mat<double, 3, 3>::Identity() * (force_unit / mass);
    B.block<3, 3>(6, 0) = cross_matrix(foot - com) * force_unit;
    B.block<3, 3>(6, 3) = Mat<double, 3, 3>::Identity() * torque_unit;
    return B;
  };
  const Matrix9 I = Matrix9::Identity();
  const Matrix9 A = I + dt * Ac + 0.5 * dt * dt * Ac * Ac;
  const Matrix9 E = dt * I + 0.5 * dt * dt * Ac + dt * dt * dt / 6.0 * Ac * Ac;
  const Matrix96 left = E * input_matrix(left_foot), right = E * input_matrix(right_foot);
  const CentroidalState b = E * c;

  const robots::SupportPolygon hull = robots::SupportPolygon::under(
      {{robots::flat_sole(left_foot), sole}, {robots::flat_sole(right_foot), sole}});
  const robots::SupportPolygon::HalfPlanes planes = hull.half_planes();
  const robots::Point2 centroid = hull.centroid();
  CentroidalState desired = CentroidalState::Zero();
  desired.head<3>() << centroid, height;
  CentroidalState always, after;
  always << 0, 0, 2000, 10, 10, 100, 10, 10, 10;
  after << 2000, 2000, 2000, 50, 50, 50, 50, 50, 50;
  constexpr double capture_weight = 1000.0;
  Mat<double, 2, 9> capture = Mat<double, 2, 9>::Zero();
  capture(0, 0) = capture(1, 1) = 1.0;
  capture(0, 3) = capture(1, 4) = 1.0 / omega;
  Vec<double, 6> wrench_weight;
  wrench_weight << Vec<double, 3>::Constant(1e-4 * force_unit * force_unit),
      Vec<double, 3>::Constant(1e-3 * torque_unit * torque_unit);
  MatrixXd cone_matrix;
  VectorXd cone_limits;
  cone(cone_matrix, cone_limits);

  const int N = options.intervals;
  std::vector<qp::StageCapacity> capacity;
  for (int k = 0; k <= N; ++k) {
    const bool landed = k >= options.landing;
    qp::StageCapacity& s = capacity.emplace_back();
    s.nx = 9;
    s.nu = k == N ? 0 : landed ? 12 : 6;
    if (k < N) s.groups.push_back({cone_rows, 6});
    if (k < N && landed) s.groups.push_back({cone_rows, 6});
    if (landed && k > 0) s.groups.push_back({planes.rows(), 4});
  }
  qp::StageQp qp(capacity);
  qp.start = start;
  for (int k = 0; k <= N; ++k) {
    qp::Stage& s = qp.stages[k];
    const bool landed = k >= options.landing, last = k == N;
    // Deviation costs w/2 (x - desired)^2, kept with their constant parts.
    const CentroidalState w =
        last ? after : CentroidalState(dt * (landed ? CentroidalState(always + after) : always));
    s.Q = w.asDiagonal();
    s.q = -w.cwiseProduct(desired);
    s.constant = 0.5 * desired.dot(w.cwiseProduct(desired));
    if (landed && !last) {
      const double weight_k = dt * capture_weight;
      s.Q += weight_k * capture.transpose() * capture;
      s.q -= weight_k * capture.transpose() * centroid;
      s.constant += 0.5 * weight_k * centroid.squaredNorm();
    }
    std::size_t group = 0;
    const auto rows = [&](const MatrixXd& M, const VectorXd& upper, std::vector<int> columns) {
      qp::RowGroup& g = s.groups[group++];
      g.rows = static_cast<int>(M.rows());
      g.columns = std::move(columns);
      g.M = M;
      g.upper = upper;
    };
    if (!last) {
      s.A = A;
      s.B.leftCols<6>() = left;
      if (landed) s.B.rightCols<6>() = right;
      s.b = b;
      for (int foot = 0; foot < s.nu / 6; ++foot) {
        s.R.diagonal().segment<6>(6 * foot) = dt * wrench_weight;
        const int first = 9 + 6 * foot;
        rows(cone_matrix, cone_limits,
             {first, first + 1, first + 2, first + 3, first + 4, first + 5});
      }
      if (landed) s.resultant_size = 6;
    }
    if (landed && k > 0) {
      const MatrixXd M = planes.A * capture;
      MatrixXd touched(M.rows(), 4);
      touched << M.col(0), M.col(1), M.col(3), M.col(4);
      rows(touched, planes.b, {0, 1, 3, 4});
    }
  }
  return qp;
}

qp::StagePoint standing_guess(const qp::StageQp& qp) {
  qp::StagePoint point(qp);
  for (std::size_t k = 0; k < qp.stages.size(); ++k) {
    const int feet = qp.stages[k].nu / 6;
    for (int foot = 0; foot < feet; ++foot)
      point.stages[k].u[6 * foot + 2] = mass * gravity / force_unit / feet;
  }
  return point;
}

}  // namespace saltus::bench
