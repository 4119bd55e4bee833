// What a least-squares term tracks: nothing, a constant, or a trajectory in time.
#pragma once

#include <vector>

#include "saltus/core/types.hpp"

namespace saltus {

/// A reference signal of m entries. Between samples it is linear, outside it keeps the end values.
class Reference {
 public:
  /// Zero, of any size.
  Reference();
  Reference(const Reference& other);
  Reference(Reference&& other) noexcept;
  Reference& operator=(const Reference& other);
  Reference& operator=(Reference&& other) noexcept;
  ~Reference();
  /// Constant.
  Reference(VectorXd value);  // NOLINT(google-explicit-constructor)
  /// Samples at increasing absolute times (s); one column of `values` per time. Throws
  /// DefinitionError when sizes differ or times do not increase.
  Reference(std::vector<double> times, MatrixXd values);

  /// Whether it is zero all the time.
  bool is_zero() const { return values_.size() == 0; }
  /// Whether it depends on the time.
  bool varies() const { return times_.size() > 1; }
  /// Whether every number is finite.
  bool is_finite() const { return values_.allFinite(); }
  /// How many numbers it has at an instant.
  int size() const { return static_cast<int>(values_.rows()); }
  /// Entry i at time t; NaN at NaN, if it varies. Throws DefinitionError if there is no entry i.
  double at(double t, int i) const;
  /// Its time derivative (right-sided at a sample).
  double rate(double t, int i) const;

 private:
  void check_entry(int i) const;
  int segment(double t) const;
  std::vector<double> times_;
  MatrixXd values_;
};

}  // namespace saltus
