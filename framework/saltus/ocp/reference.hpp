// Reference of a least-squares term: zero, a constant, or a trajectory in time.
#pragma once

#include <vector>

#include "saltus/core/types.hpp"

namespace saltus {

/// A reference signal with m entries. Linear between samples, constant before the first and after
/// the last one.
class Reference {
 public:
  /// Zero, for any size.
  Reference();
  Reference(const Reference& other);
  Reference(Reference&& other) noexcept;
  Reference& operator=(const Reference& other);
  Reference& operator=(Reference&& other) noexcept;
  ~Reference();
  /// A constant.
  Reference(VectorXd value);  // NOLINT(google-explicit-constructor)
  /// Samples at increasing absolute times in seconds, one column of `values` per time. Throws
  /// DefinitionError if sizes differ or times do not increase.
  Reference(std::vector<double> times, MatrixXd values);

  /// True if it is zero at all times.
  bool is_zero() const { return values_.size() == 0; }
  /// True if it depends on time.
  bool varies() const { return times_.size() > 1; }
  /// True if all its numbers are finite.
  bool is_finite() const;
  /// Number of entries.
  int size() const { return static_cast<int>(values_.rows()); }
  /// Entry i at time t. NaN if t is NaN and the reference varies. Throws DefinitionError if there
  /// is no entry i.
  double at(double t, int i) const;
  /// Time derivative of entry i, right-sided at a sample.
  double rate(double t, int i) const;

 private:
  void check_entry(int i) const;
  int segment(double t) const;
  std::vector<double> times_;
  MatrixXd values_;
};

}  // namespace saltus
