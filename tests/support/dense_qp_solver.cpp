#include "tests/support/dense_qp_solver.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "tests/support/dense_algebra.hpp"

namespace saltus::testing_support {
namespace {

// A finite side of a row or bound, written as sign (a'w) + s = sign limit with s >= 0.
struct Side {
  int row;  // rows first, then bounds
  double sign, limit;
};

class DenseQpSolver final : public qp::QpSolver {
 public:
  explicit DenseQpSolver(const qp::QpOptions& options) : options_(options) {}
  void set_deadline(WallClock::time_point deadline) override { deadline_ = deadline; }
  std::string name() const override { return "dense test solver"; }

  qp::QpResult solve(const qp::SparseQp& qp, PrimalDualPoint& point, bool) noexcept override {
    const int n = qp.variables(), m = qp.row_pattern.rows();
    MatrixXd H = MatrixXd::Zero(n, n), A = MatrixXd::Zero(m + n, n);
    qp.hessian_pattern.for_each([&](int r, int c, int e) { H(r, c) = H(c, r) = qp.hessian[e]; });
    qp.row_pattern.for_each([&](int r, int c, int e) { A(r, c) = qp.rows[e]; });
    A.bottomRows(n).setIdentity();
    VectorXd lower(m + n), upper(m + n);
    lower << qp.row_lower, qp.lower;
    upper << qp.row_upper, qp.upper;

    qp::QpResult result;
    if (!H.allFinite() || !A.allFinite() || !(lower.array() <= upper.array()).all()) return result;
    std::vector<Side> sides;
    std::vector<int> equal;
    for (int i = 0; i < m + n; ++i) {
      if (lower[i] == upper[i]) {
        equal.push_back(i);
        continue;
      }
      if (std::isfinite(lower[i])) sides.push_back({i, -1.0, lower[i]});
      if (std::isfinite(upper[i])) sides.push_back({i, 1.0, upper[i]});
    }
    const int me = static_cast<int>(equal.size()), mi = static_cast<int>(sides.size());
    VectorXd w = point.w, y = VectorXd::Zero(me), s(mi), l = VectorXd::Ones(mi);
    for (int k = 0; k < mi; ++k)
      s[k] = std::max(1.0, sides[k].sign * (sides[k].limit - A.row(sides[k].row).dot(w)));

    double best = infinity;
    const auto keep = [&](double residual) {
      if (!(residual < best)) return;
      best = residual;
      point.w = w;
      VectorXd all = VectorXd::Zero(m + n);
      for (int k = 0; k < me; ++k) all[equal[k]] = y[k];
      for (int k = 0; k < mi; ++k) all[sides[k].row] += sides[k].sign * l[k];
      point.lambda = all.head(m);
      point.z = all.tail(n);
    };
    result.status = qp::QpStatus::iteration_limit;
    MatrixXd kkt(n + me, n + me);
    for (result.iterations = 0; result.iterations < options_.max_iterations; ++result.iterations) {
      if (WallClock::now() > deadline_) {
        result.status = qp::QpStatus::deadline;
        break;
      }
      VectorXd rd = H * w + qp.gradient, re(me), ri(mi);
      for (int k = 0; k < me; ++k) {
        rd += y[k] * A.row(equal[k]).transpose();
        re[k] = A.row(equal[k]).dot(w) - lower[equal[k]];
      }
      for (int k = 0; k < mi; ++k) {
        rd += sides[k].sign * l[k] * A.row(sides[k].row).transpose();
        ri[k] = sides[k].sign * (A.row(sides[k].row).dot(w) - sides[k].limit) + s[k];
      }
      const double gap = mi > 0 ? s.dot(l) / mi : 0.0;
      const auto size = [](const VectorXd& v) { return v.size() ? v.cwiseAbs().maxCoeff() : 0.0; };
      const double worst =
          std::max({size(rd), size(re), size(ri), mi > 0 ? s.cwiseProduct(l).maxCoeff() : 0.0});
      keep(worst);
      if (worst <= 0.1 * options_.tolerance) {
        result.status = qp::QpStatus::optimal;
        break;
      }
      if (!(worst < 1e20)) break;

      kkt.setZero();
      kkt.topLeftCorner(n, n) = H;
      kkt.topLeftCorner(n, n).diagonal().array() += 1e-12;
      for (int k = 0; k < mi; ++k)
        kkt.topLeftCorner(n, n) +=
            (l[k] / s[k]) * A.row(sides[k].row).transpose() * A.row(sides[k].row);
      for (int k = 0; k < me; ++k) {
        kkt.row(n + k).head(n) = A.row(equal[k]);
        kkt(n + k, n + k) = -1e-12;
      }
      kkt.topRightCorner(n, me) = kkt.bottomLeftCorner(me, n).transpose();
      const auto solve = testing::solver_of(kkt);
      VectorXd dw, dy, ds(mi), dl(mi);
      const auto direction = [&](const VectorXd& products) {
        VectorXd rhs(n + me);
        rhs << -rd, -re;
        for (int k = 0; k < mi; ++k)
          rhs.head(n) -= sides[k].sign * ((l[k] * ri[k] - products[k]) / s[k]) *
                         A.row(sides[k].row).transpose();
        VectorXd d = solve(rhs);
        d += solve(rhs - kkt * d);
        dw = d.head(n);
        dy = d.tail(me);
        for (int k = 0; k < mi; ++k) {
          ds[k] = -ri[k] - sides[k].sign * A.row(sides[k].row).dot(dw);
          dl[k] = (-products[k] - l[k] * ds[k]) / s[k];
        }
      };
      const auto longest = [&](const VectorXd& v, const VectorXd& dv) {
        double alpha = 1.0;
        for (int k = 0; k < v.size(); ++k)
          if (dv[k] < 0.0) alpha = std::min(alpha, -0.99 * v[k] / dv[k]);
        return alpha;
      };
      const VectorXd products = s.cwiseProduct(l);
      direction(products);
      if (mi > 0) {
        const double ap = longest(s, ds), ad = longest(l, dl);
        const double mu = (s + ap * ds).dot(l + ad * dl) / mi;
        direction(products + ds.cwiseProduct(dl) -
                  VectorXd::Constant(mi, std::pow(mu / gap, 3) * gap));
      }
      const double alpha = std::min(longest(s, ds), longest(l, dl));
      w += alpha * dw;
      s += alpha * ds;
      y += alpha * dy;
      l += alpha * dl;
    }
    const qp::SparseQp::Residual residual = kkt_residual(qp, point);
    result.objective = objective(qp, point.w);
    result.residual = residual.largest();
    result.violation = residual.feasibility;
    if (result.status == qp::QpStatus::iteration_limit && result.residual <= options_.tolerance)
      result.status = qp::QpStatus::optimal;
    // This solver has no certificates: a violation that remains counts as infeasible.
    if (result.status == qp::QpStatus::iteration_limit && residual.feasibility > 1e-6)
      result.status = qp::QpStatus::infeasible;
    return result;
  }

 private:
  qp::QpOptions options_;
  WallClock::time_point deadline_ = WallClock::time_point::max();
};

}  // namespace

std::unique_ptr<qp::QpSolver> make_dense_qp_solver(const SparsityPattern&, const SparsityPattern&,
                                                   const qp::QpOptions& options) {
  return std::make_unique<DenseQpSolver>(options);
}

}  // namespace saltus::testing_support
