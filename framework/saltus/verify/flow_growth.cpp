#include "saltus/verify/flow_growth.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

namespace saltus {

// Plane rotations that make the columns orthogonal (Hestenes 1958). Plain loops, because a
// decomposition of Eigen takes ten seconds to compile.
double largest_singular_value(MatrixXd A) {
  const auto product = [&](int p, int q) {
    double sum = 0.0;
    for (int i = 0; i < A.rows(); ++i) sum += A(i, p) * A(i, q);
    return sum;
  };
  const int columns = static_cast<int>(A.cols()), enough_sweeps = 50;
  bool rotated = true;
  for (int sweep = 0; rotated && sweep < enough_sweeps; ++sweep) {
    rotated = false;
    for (int p = 0; p < columns; ++p)
      for (int q = p + 1; q < columns; ++q) {
        const double pp = product(p, p), qq = product(q, q), pq = product(p, q);
        if (!(std::abs(pq) > std::numeric_limits<double>::epsilon() * std::sqrt(pp * qq))) continue;
        const double cotangent = (qq - pp) / (2.0 * pq);  // of the doubled rotation angle
        const double tangent = std::copysign(1.0, cotangent) /
                               (std::abs(cotangent) + std::sqrt(1.0 + cotangent * cotangent));
        const double c = 1.0 / std::sqrt(1.0 + tangent * tangent), s = c * tangent;
        for (int i = 0; i < A.rows(); ++i) {
          const double a = A(i, p), b = A(i, q);
          A(i, p) = c * a - s * b;
          A(i, q) = s * a + c * b;
        }
        rotated = true;
      }
  }
  double largest = 0.0;
  for (int p = 0; p < columns; ++p) largest = std::max(largest, std::sqrt(product(p, p)));
  return largest;
}

void FlowGrowth::begin(int n) {
  columns_ = MatrixXd::Zero(n, n + 1);
  for (int i = 0; i < n; ++i) columns_(i, i) = 1.0;
}

// product_ = length * jacobian * by
void FlowGrowth::multiply(const MatrixXd& by, const std::vector<double>& jacobian, double length) {
  const auto n = by.rows();
  product_.setZero(n, by.cols());
  for (Eigen::Index i = 0; i < n; ++i)
    for (Eigen::Index j = 0; j < n; ++j) {
      const double factor = length * jacobian[i * n + j];
      if (factor == 0.0) continue;
      for (Eigen::Index k = 0; k < by.cols(); ++k) product_(i, k) += factor * by(j, k);
    }
}

void FlowGrowth::step(const std::vector<double>& jacobian, double length) {
  const int n = static_cast<int>(columns_.rows());
  double norm = 0.0;
  for (int i = 0; i < n; ++i) {
    double sum = 0.0;
    for (int j = 0; j < n; ++j) sum += std::abs(length * jacobian[i * n + j]);
    norm = std::max(norm, sum);
  }
  constexpr double most_of_series = 4.0;  // limit at which ten terms are accurate to a few digits
  if (norm <= most_of_series) {
    term_ = columns_;
    constexpr int terms = 12;
    for (int k = 1; k <= terms; ++k) {
      multiply(term_, jacobian, length / k);
      term_.swap(product_);
      columns_ += term_;
      if (term_.size() == 0 || !(norm > 0.0)) break;
      if (std::pow(norm, k) < 1e-6 * std::tgamma(k + 1.0)) break;
    }
    return;
  }
  // Stiff: (1 + (1 - 2 g) z) / (1 - g z)^2, L-stable of order 2 with g = 1 - 1 / sqrt(2).
  constexpr double g = 1.0 - 1.0 / std::numbers::sqrt2;
  detail::DenseLu lu(n);
  for (int i = 0; i < n; ++i)
    for (int j = 0; j < n; ++j)
      lu.row(i)[j] = (i == j ? 1.0 : 0.0) - g * length * jacobian[i * n + j];
  if (!lu.factor()) return;
  multiply(columns_, jacobian, (1.0 - 2.0 * g) * length);
  columns_ += product_;
  for (Eigen::Index k = 0; k < columns_.cols(); ++k) {
    VectorXd column = columns_.col(k);
    lu.solve(column.data());
    lu.solve(column.data());
    columns_.col(k) = column;
  }
}

double FlowGrowth::growth(const VectorXd& start_units, const VectorXd& units) const {
  const auto starts = columns_.cols() - 1;
  MatrixXd scaled = columns_.leftCols(starts);
  for (Eigen::Index i = 0; i < scaled.rows(); ++i)
    for (Eigen::Index j = 0; j < starts; ++j) scaled(i, j) *= start_units[j] / units[i];
  if (!scaled.allFinite()) return std::numeric_limits<double>::infinity();
  return largest_singular_value(std::move(scaled));
}

}  // namespace saltus
