#include "tests/problems/dense_qp.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/dense_algebra.hpp"

namespace saltus::testing {
namespace {

double largest(const VectorXd& v) { return v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0.0; }

// The longest step in [0, 1] that keeps v + step dv slightly above zero.
double longest_step(const VectorXd& v, const VectorXd& dv) {
  constexpr double to_the_boundary = 0.999;
  double step = 1.0;
  for (Eigen::Index i = 0; i < v.size(); ++i)
    if (dv[i] < 0.0) step = std::min(step, -to_the_boundary * v[i] / dv[i]);
  return step;
}

// Residual of the optimality conditions, with w exactly zero on rows that are not active.
double residual(const DenseQp& p, const DenseQpResult& r) {
  const VectorXd gradient = p.P * r.z + p.q + p.A.transpose() * r.y + p.G.transpose() * r.w;
  return std::max({largest(gradient), largest(p.A * r.z - p.b),
                   std::max(0.0, (p.G * r.z - p.h).maxCoeff()), std::max(0.0, -r.w.minCoeff())});
}

// Interior-point iterations until the gap identifies the active rows.
void approach(const DenseQp& p, DenseQpResult& r, VectorXd& slack) {
  constexpr double gap_wanted = 1e-9;
  constexpr int most_iterations = 60;
  const Eigen::Index n = p.q.size(), me = p.b.size(), mi = p.h.size();
  const auto count = static_cast<double>(mi);
  r.z = VectorXd::Zero(n);
  r.y = VectorXd::Zero(me);
  r.w = VectorXd::Ones(mi);
  slack = (p.h - p.G * r.z).cwiseMax(1.0);
  for (r.iterations = 0; r.iterations < most_iterations; ++r.iterations) {
    const VectorXd dual = p.P * r.z + p.q + p.A.transpose() * r.y + p.G.transpose() * r.w;
    const VectorXd equal = p.A * r.z - p.b;
    const VectorXd inside = p.G * r.z + slack - p.h;
    const double gap = slack.dot(r.w) / count;
    if (std::max({gap, largest(dual), largest(equal), largest(inside)}) < gap_wanted) return;

    MatrixXd kkt = MatrixXd::Zero(n + me, n + me);
    kkt.topLeftCorner(n, n) = p.P + p.G.transpose() * r.w.cwiseQuotient(slack).asDiagonal() * p.G;
    kkt.topRightCorner(n, me) = p.A.transpose();
    kkt.bottomLeftCorner(me, n) = p.A;
    const auto solve = solver_of(kkt);
    VectorXd dz, dy, dw, ds;
    // Newton step that reduces the products of slack and w by `target`.
    const auto direction = [&](const VectorXd& target) {
      VectorXd rhs(n + me);
      rhs << -dual - p.G.transpose() * (r.w.cwiseProduct(inside) - target).cwiseQuotient(slack),
          -equal;
      const VectorXd step = solve(rhs);
      dz = step.head(n);
      dy = step.tail(me);
      ds = -inside - p.G * dz;
      dw = (-target - r.w.cwiseProduct(ds)).cwiseQuotient(slack);
    };
    const VectorXd products = slack.cwiseProduct(r.w);
    direction(products);
    const double predicted =
        (slack + longest_step(slack, ds) * ds).dot(r.w + longest_step(r.w, dw) * dw) / count;
    const double centring = std::pow(predicted / gap, 3);
    direction(products + ds.cwiseProduct(dw) - VectorXd::Constant(mi, centring * gap));
    const double primal_step = longest_step(slack, ds), dual_step = longest_step(r.w, dw);
    r.z += primal_step * dz;
    slack += primal_step * ds;
    r.y += dual_step * dy;
    r.w += dual_step * dw;
  }
}

// Optimum with these rows as equations and without the others, with one refinement step.
void solve_with(const DenseQp& p, const std::vector<bool>& is_active, DenseQpResult& r) {
  std::vector<Eigen::Index> active;
  for (Eigen::Index i = 0; i < p.h.size(); ++i)
    if (is_active[i]) active.push_back(i);
  const Eigen::Index n = p.q.size(), me = p.b.size();
  const auto ma = static_cast<Eigen::Index>(active.size());
  MatrixXd kkt = MatrixXd::Zero(n + me + ma, n + me + ma);
  VectorXd rhs(n + me + ma);
  kkt.topLeftCorner(n, n) = p.P;
  kkt.block(n, 0, me, n) = p.A;
  rhs.head(n) = -p.q;
  rhs.segment(n, me) = p.b;
  for (Eigen::Index i = 0; i < ma; ++i) {
    kkt.row(n + me + i).head(n) = p.G.row(active[i]);
    rhs[n + me + i] = p.h[active[i]];
  }
  kkt.topRightCorner(n, me + ma) = kkt.bottomLeftCorner(me + ma, n).transpose();
  const auto solve = least_squares_of(kkt);
  VectorXd solution = solve(rhs);
  solution += solve(rhs - kkt * solution);
  r.z = solution.head(n);
  r.y = solution.segment(n, me);
  r.w.setZero();
  for (Eigen::Index i = 0; i < ma; ++i) r.w[active[i]] = solution[n + me + i];
}

// Rows with a multiplier above their slack become equations. The remaining undecided rows are
// dropped or added until all signs are correct.
void polish(const DenseQp& p, DenseQpResult& r, const VectorXd& slack) {
  constexpr double undecided = 1e-10;
  constexpr int max_corrections = 20;
  std::vector<bool> is_active(p.h.size());
  for (Eigen::Index i = 0; i < p.h.size(); ++i) is_active[i] = r.w[i] > slack[i];
  for (int correction = 0; correction < max_corrections; ++correction) {
    solve_with(p, is_active, r);
    const VectorXd outside = p.G * r.z - p.h;
    bool is_right = true;
    for (Eigen::Index i = 0; i < p.h.size(); ++i) {
      if (is_active[i] ? r.w[i] >= -undecided : outside[i] <= undecided) continue;
      is_active[i] = !is_active[i];
      is_right = false;
    }
    if (is_right) return;
  }
}

}  // namespace

DenseQpResult solve(const DenseQp& qp, double tolerance) {
  const auto scale = qp.scale.asDiagonal();
  DenseQp p;
  p.P = scale * qp.P * scale;
  p.q = scale * qp.q;
  p.A = qp.A * scale;
  p.G = qp.G * scale;
  p.b = qp.b;
  p.h = qp.h;
  DenseQpResult r;
  VectorXd slack;
  approach(p, r, slack);
  polish(p, r, slack);
  r.residual = residual(p, r);
  r.optimal = r.residual <= tolerance;
  r.z = scale * r.z;
  r.cost = 0.5 * r.z.dot(qp.P * r.z) + qp.q.dot(r.z) + qp.constant;
  return r;
}

}  // namespace saltus::testing
