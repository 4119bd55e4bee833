// Time of a plant: its start plus the sum of its steps. Far from zero, where adjacent doubles are
// 1e-7 s apart, steps shorter than that still count.
#pragma once

namespace saltus {

/// Kahan summation: the error does not grow with the number of steps.
class PlantClock {
 public:
  /// Starts at `start` seconds.
  explicit PlantClock(double start) : start_(start) {}

  /// Current time in seconds.
  double time() const { return start_ + elapsed_; }
  /// Advances by `length` seconds.
  void move_on(double length) {
    const double added = length + missing_, sum = elapsed_ + added;
    missing_ = added - (sum - elapsed_);
    elapsed_ = sum;
  }

 private:
  double start_, elapsed_ = 0.0;
  double missing_ = 0.0;  // rounding error of elapsed_
};

}  // namespace saltus
