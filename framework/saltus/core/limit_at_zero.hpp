// The limit of a smooth function of d > 0 at d = 0, from its values at d, d/2, d/4, ...
#pragma once

#include <algorithm>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

/// Neville's polynomial through the values, at zero. Of its tableau the entry counts that differs
/// least from its neighbours, and that difference is the estimated error.
class LimitAtZero {
 public:
  /// At half the distance of the value before.
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
  /// The limit, as far as it was found.
  const VectorXd& value() const { return best_; }
  /// Infinite before the second value.
  double error() const { return error_; }

 private:
  static double largest(const VectorXd& v) { return v.size() > 0 ? v.cwiseAbs().maxCoeff() : 0.0; }
  std::vector<VectorXd> before_;
  VectorXd best_;
  double error_ = infinity;
};

}  // namespace saltus
