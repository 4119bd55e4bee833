#include "saltus/qp/sparse_qp.hpp"

#include <algorithm>
#include <array>
#include <utility>

#include "saltus/qp/side_residual.hpp"

namespace saltus::qp {

SparseQp::SparseQp(SparsityPattern hessian_shape, SparsityPattern row_shape)
    : hessian_pattern(std::move(hessian_shape)),
      row_pattern(std::move(row_shape)),
      hessian(VectorXd::Zero(hessian_pattern.entries())),
      rows(VectorXd::Zero(row_pattern.entries())),
      gradient(VectorXd::Zero(row_pattern.cols())),
      lower(VectorXd::Constant(row_pattern.cols(), -infinity)),
      upper(VectorXd::Constant(row_pattern.cols(), infinity)),
      row_lower(VectorXd::Constant(row_pattern.rows(), -infinity)),
      row_upper(VectorXd::Constant(row_pattern.rows(), infinity)) {}

namespace {

double row_times(const SparsityPattern& pattern, int row, const VectorXd& values,
                 const VectorXd& w) {
  double sum = 0.0;
  for (int e = pattern.row_begin(row); e < pattern.row_end(row); ++e)
    sum += values[e] * w[pattern.col(e)];
  return sum;
}

}  // namespace

double objective(const SparseQp& qp, const VectorXd& w) {
  double sum = qp.constant + qp.gradient.dot(w);
  qp.hessian_pattern.for_each([&](int row, int col, int e) {
    sum += (row == col ? 0.5 : 1.0) * w[row] * qp.hessian[e] * w[col];
  });
  return sum;
}

double SparseQp::Residual::largest() const {
  return std::max({stationarity, feasibility, complementarity});
}

SparseQp::Residual kkt_residual(const SparseQp& qp, const PrimalDualPoint& point) {
  SparseQp::Residual worst;
  // The function does not allocate and cannot hold a whole gradient, which the patterns fill by
  // rows. It therefore visits the matrices once per block of variables.
  constexpr int block = 256;
  std::array<double, block> gradient;
  const int n = qp.variables();
  for (int first = 0; first < n; first += block) {
    const int last = std::min(first + block, n);
    const auto add = [&](int i, double value) {
      if (i >= first && i < last) gradient[i - first] += value;
    };
    for (int i = first; i < last; ++i) gradient[i - first] = qp.gradient[i] + point.z[i];
    qp.hessian_pattern.for_each([&](int row, int col, int e) {
      add(row, qp.hessian[e] * point.w[col]);
      if (row != col) add(col, qp.hessian[e] * point.w[row]);
    });
    qp.row_pattern.for_each(
        [&](int row, int col, int e) { add(col, qp.rows[e] * point.lambda[row]); });
    for (int i = first; i < last; ++i) raise(worst.stationarity, gradient[i - first]);
  }
  for (int i = 0; i < n; ++i)
    add_hard(point.w[i], qp.lower[i], qp.upper[i], point.z[i], worst.feasibility,
             worst.complementarity);
  for (int row = 0; row < qp.row_pattern.rows(); ++row)
    add_hard(row_times(qp.row_pattern, row, qp.rows, point.w), qp.row_lower[row], qp.row_upper[row],
             point.lambda[row], worst.feasibility, worst.complementarity);
  return worst;
}

}  // namespace saltus::qp
