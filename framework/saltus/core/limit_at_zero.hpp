// Extrapolates a smooth function of d > 0 to d = 0 from its values at d, d/2, d/4, ...
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

/// Evaluates Neville's interpolating polynomial at zero. value() is the tableau entry that differs
/// least from its neighbours. That difference is the error estimate.
class LimitAtZero {
 public:
  /// Adds the value at half the previous distance.
  void add(const VectorXd& value) {
    std::vector<VectorXd> row{value};
    double weight = 1.0;
    for (std::size_t k = 1; k <= before_.size(); ++k) {
      weight *= 2.0;
      row.push_back(row[k - 1] + (row[k - 1] - before_[k - 1]) / (weight - 1.0));
      const double change =
          std::max(largest(row[k] - row[k - 1]), largest(row[k] - before_[k - 1]));
      if (!(change < error_)) continue;
      error_ = change;
      best_ = row[k];
    }
    if (before_.empty()) best_ = value;
    before_ = std::move(row);
  }
  /// Best estimate of the limit.
  const VectorXd& value() const { return best_; }
  /// Estimated error of value(), largest entry. Infinite before the second value.
  double error() const { return error_; }

 private:
  static double largest(const VectorXd& v) { return v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0.0; }
  std::vector<VectorXd> before_;
  VectorXd best_;
  double error_ = infinity;
};

}  // namespace saltus
