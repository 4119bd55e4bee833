#include "saltus/solver/elastic_qp.hpp"

#include <algorithm>
#include <utility>
#include <vector>

namespace saltus {

ElasticQp::ElasticQp(const NonlinearProgram& program, const qp::SparseQp& shape,
                     const QpMethod& method, const qp::QpOptions& options) {
  const int n = shape.variables(), m = shape.row_pattern.rows();
  std::vector<std::pair<int, int>> hessian, rows;
  shape.hessian_pattern.for_each([&](int r, int c, int) { hessian.emplace_back(r, c); });
  shape.row_pattern.for_each([&](int r, int c, int) { rows.emplace_back(r, c); });
  for (int i = 0; i < m; ++i) {
    rows.emplace_back(i, n + i);
    rows.emplace_back(i, n + m + i);
  }
  const int all = n + 2 * m;
  qp_ = qp::SparseQp(SparsityPattern::from_pairs(all, all, std::move(hessian)),
                     SparsityPattern::from_pairs(m, all, std::move(rows)));
  shape.row_pattern.for_each(
      [&](int r, int c, int) { position_.push_back(qp_.row_pattern.find(r, c)); });
  for (int i = 0; i < m; ++i) {
    qp_.rows[qp_.row_pattern.find(i, n + i)] = 1.0;
    qp_.rows[qp_.row_pattern.find(i, n + m + i)] = -1.0;
  }
  qp_.lower.tail(2 * m).setZero();
  point_ = {VectorXd::Zero(all), VectorXd::Zero(m), VectorXd::Zero(all)};
  solver_ = method(program, qp_.hessian_pattern, qp_.row_pattern, options);
}

qp::QpResult ElasticQp::solve(const qp::SparseQp& qp, double weight, PrimalDualPoint& point,
                              WallClock::time_point deadline) {
  const int n = qp.variables(), m = qp.row_pattern.rows();
  qp_.hessian = qp.hessian;  // slacks have no curvature: the entries are the same
  for (std::size_t e = 0; e < position_.size(); ++e) qp_.rows[position_[e]] = qp.rows[e];
  qp_.gradient.head(n) = qp.gradient;
  qp_.gradient.tail(2 * m).setConstant(weight);
  qp_.constant = qp.constant;
  qp_.lower.head(n) = qp.lower;
  qp_.upper.head(n) = qp.upper;
  qp_.row_lower = qp.row_lower;
  qp_.row_upper = qp.row_upper;

  point_.w.setZero();
  point_.w.head(n) = point.w;
  VectorXd rows = VectorXd::Zero(m);
  qp.row_pattern.for_each([&](int r, int c, int e) { rows[r] += qp.rows[e] * point.w[c]; });
  for (int i = 0; i < m; ++i) {
    point_.w[n + i] = std::max(qp.row_lower[i] - rows[i], 0.0);
    point_.w[n + m + i] = std::max(rows[i] - qp.row_upper[i], 0.0);
  }
  solver_->set_deadline(deadline);
  const qp::QpResult result = solver_->solve(qp_, point_, false);
  point.w = point_.w.head(n);
  point.lambda = point_.lambda;
  point.z = point_.z.head(n);
  return result;
}

}  // namespace saltus
