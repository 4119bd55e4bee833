// Detects runs that keep returning to points they have left.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

namespace saltus {

/// Cost and violation identify an iterate. The filter permits cycles if each round lowers the cost
/// by a little, for example in badly scaled programs whose steps are inaccurate. A return is an
/// iterate that is close to an earlier one, with another one in between that is far from both.
class CycleWatch {
 public:
  /// Removes all iterates.
  void restart() { count_ = returns_ = 0; }

  /// Adds an iterate. Returns true after `most_returns` returns.
  bool is_cycling(double cost, double violation) {
    const Iterate now{cost, violation};
    bool has_left = false;
    for (int age = 1; age <= std::min(count_, window); ++age) {
      const Iterate& before = iterates_[(count_ - age) % window];
      if (has_left && are_within(close, now, before)) {
        ++returns_;
        break;
      }
      has_left = has_left || !are_within(far, now, before);
    }
    iterates_[count_++ % window] = now;
    return returns_ >= most_returns;
  }

 private:
  struct Iterate {
    double cost = 0.0, violation = 0.0;
  };
  static constexpr int window = 48, most_returns = 20;
  static constexpr double close = 1e-3, far = 0.1;  // relative differences

  static bool are_within(double tolerance, const Iterate& a, const Iterate& b) {
    return std::abs(a.cost - b.cost) <= tolerance * std::abs(a.cost) &&
           std::abs(a.violation - b.violation) <= tolerance * a.violation;
  }

  std::array<Iterate, window> iterates_;
  int count_ = 0, returns_ = 0;
};

}  // namespace saltus
