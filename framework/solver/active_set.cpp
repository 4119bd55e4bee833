#include "framework/solver/active_set.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <cmath>

namespace saltus {
namespace {

constexpr double dependent = 1e-10;  // pivots of R below this, relative to the largest, are zero
// Added to the curvature, relative to the largest: flat directions count as convex, and at
// solutions where the curvature vanishes Newton's method still approaches.
constexpr double flat = 1e-10;

int side(double multiplier, double value, double lower, double upper) {
  if (lower == upper) return 1;
  const double room = multiplier > 0.0 ? upper - value : value - lower;
  if (!std::isfinite(room) || std::abs(multiplier) <= room) return 0;
  return multiplier > 0.0 ? 1 : -1;
}

// The surface of some rows, on the variables that are free.
struct Surface {
  Surface(const SparseQp& qp, const std::vector<int>& row_sides,
          const std::vector<int>& bound_sides)
      : place(bound_sides.size(), -1), known(VectorXd::Zero(qp.variables())) {
    for (int i = 0; i < qp.variables(); ++i)
      if (bound_sides[i] != 0)
        known[i] = bound_sides[i] > 0 ? qp.upper[i] : qp.lower[i];
      else
        place[i] = free++;
    std::vector<int> row_place(row_sides.size(), -1);
    for (std::size_t i = 0; i < row_sides.size(); ++i)
      if (row_sides[i] != 0) {
        row_place[i] = static_cast<int>(rows.size());
        rows.push_back(static_cast<int>(i));
      }
    b.resize(static_cast<Eigen::Index>(rows.size()));
    for (std::size_t k = 0; k < rows.size(); ++k)
      b[k] = row_sides[rows[k]] > 0 ? qp.row_upper[rows[k]] : qp.row_lower[rows[k]];
    transposed = MatrixXd::Zero(free, b.size());
    qp.row_pattern.for_each([&](int r, int c, int e) {
      if (row_place[r] < 0) return;
      if (place[c] >= 0)
        transposed(place[c], row_place[r]) = qp.rows[e];
      else
        b[row_place[r]] -= qp.rows[e] * known[c];
    });
    H = MatrixXd::Zero(free, free);
    g = VectorXd::Zero(free);
    qp.hessian_pattern.for_each([&](int r, int c, int e) {
      if (place[r] >= 0 && place[c] >= 0)
        H(place[r], place[c]) = H(place[c], place[r]) = qp.hessian[e];
      else if (place[r] >= 0)
        g[place[r]] += qp.hessian[e] * known[c];
      else if (place[c] >= 0)
        g[place[c]] += qp.hessian[e] * known[r];
    });
    for (int i = 0; i < qp.variables(); ++i)
      if (place[i] >= 0) g[place[i]] += qp.gradient[i];

    Z = MatrixXd::Identity(free, free);
    if (transposed.size() > 0) {
      factors.setThreshold(dependent);
      factors.compute(transposed);
      rank = static_cast<int>(factors.rank());
      Z.applyOnTheLeft(factors.householderQ());
      Z = Z.rightCols(free - rank).eval();
    }
    reduced = Z.transpose() * H * Z;
    if (reduced.size() == 0) return;
    const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(reduced, Eigen::EigenvaluesOnly);
    lowest = eigen.eigenvalues().minCoeff();
    size = eigen.eigenvalues().cwiseAbs().maxCoeff();
  }
  bool is_convex() const { return lowest >= -flat * size; }

  int free = 0, rank = 0;
  std::vector<int> place;  // of every variable among the free ones, -1: known
  std::vector<int> rows;
  VectorXd known, b, g;
  MatrixXd transposed, H, Z, reduced;
  Eigen::ColPivHouseholderQR<MatrixXd> factors;
  double lowest = 0.0, size = 0.0;  // eigenvalues of Z'HZ: the lowest, the largest magnitude
};

}  // namespace

ActiveSet ActiveSet::equalities(const SparseQp& qp) {
  ActiveSet set;
  for (int i = 0; i < qp.row_lower.size(); ++i)
    set.rows_.push_back(qp.row_lower[i] == qp.row_upper[i] ? 1 : 0);
  for (int i = 0; i < qp.lower.size(); ++i)
    set.bounds_.push_back(qp.lower[i] == qp.upper[i] ? 1 : 0);
  return set;
}

ActiveSet ActiveSet::at(const SparseQp& qp, const PrimalDualPoint& point) {
  VectorXd rows = VectorXd::Zero(qp.row_lower.size());
  qp.row_pattern.for_each([&](int r, int c, int e) { rows[r] += qp.rows[e] * point.w[c]; });
  ActiveSet set;
  for (int i = 0; i < rows.size(); ++i)
    set.rows_.push_back(side(point.lambda[i], rows[i], qp.row_lower[i], qp.row_upper[i]));
  for (int i = 0; i < qp.lower.size(); ++i)
    set.bounds_.push_back(side(point.z[i], point.w[i], qp.lower[i], qp.upper[i]));
  return set;
}

double ActiveSet::missing_curvature(const SparseQp& qp, double floor) const {
  if (qp.variables() > largest) return infinity;
  const Surface s(qp, rows_, bounds_);
  return s.is_convex() ? 0.0 : floor * s.size - s.lowest;
}

bool ActiveSet::solve(const SparseQp& qp, double floor, PrimalDualPoint& point) const {
  if (qp.variables() > largest) return false;
  const Surface s(qp, rows_, bounds_);
  const auto R = s.factors.matrixR().topLeftCorner(s.rank, s.rank).triangularView<Eigen::Upper>();
  VectorXd w = VectorXd::Zero(s.free), y = VectorXd::Zero(s.b.size());
  if (s.rank > 0) {
    w.head(s.rank) =
        R.transpose().solve((s.factors.colsPermutation().transpose() * s.b).head(s.rank));
    w.applyOnTheLeft(s.factors.householderQ());
  }
  if (s.free > s.rank) {
    const VectorXd slope = s.Z.transpose() * (s.g + s.H * w);
    MatrixXd curved = s.reduced;
    if (s.lowest <= flat * s.size) curved.diagonal().array() += floor * s.size - s.lowest;
    w -= s.Z * Eigen::LLT<MatrixXd>(curved).solve(slope);
  }
  if (s.rank > 0) {
    VectorXd slope = s.g + s.H * w;
    slope.applyOnTheLeft(s.factors.householderQ().transpose());
    y.head(s.rank) = -R.solve(slope.head(s.rank));
    y = s.factors.colsPermutation() * y;
  }
  if (!w.allFinite() || !y.allFinite()) return false;

  point.lambda.setZero();
  for (std::size_t k = 0; k < s.rows.size(); ++k) point.lambda[s.rows[k]] = y[k];
  point.z = qp.gradient;
  for (int i = 0; i < qp.variables(); ++i)
    point.w[i] = s.place[i] >= 0 ? w[s.place[i]] : s.known[i];
  // z balances the gradient where bounds hold.
  qp.hessian_pattern.for_each([&](int r, int c, int e) {
    point.z[r] += qp.hessian[e] * point.w[c];
    if (r != c) point.z[c] += qp.hessian[e] * point.w[r];
  });
  qp.row_pattern.for_each([&](int r, int c, int e) { point.z[c] += qp.rows[e] * point.lambda[r]; });
  for (int i = 0; i < qp.variables(); ++i) point.z[i] = s.place[i] < 0 ? -point.z[i] : 0.0;
  return true;
}

}  // namespace saltus
