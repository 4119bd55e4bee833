// The time of a plant: where it began, and the sum of what it has moved on by since. Far from zero,
// where neighbouring numbers are 1e-7 s apart, pieces shorter than that count all the same.
#pragma once

namespace saltus {

/// Kahan's sum: its error does not grow with the number of pieces.
class PlantClock {
 public:
  /// At `start` s.
  explicit PlantClock(double start) : start_(start) {}

  /// Now, s.
  double time() const { return start_ + elapsed_; }
  /// By so many s.
  void move_on(double length) {
    const double added = length + missing_, sum = elapsed_ + added;
    missing_ = added - (sum - elapsed_);
    elapsed_ = sum;
  }

 private:
  double start_, elapsed_ = 0.0;
  double missing_ = 0.0;  // of elapsed_, by rounding
};

}  // namespace saltus
