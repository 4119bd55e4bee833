// The filter that accepts points: it rejects a point if a stored point is better in both violation
// and cost.
//
// Fletcher and Leyffer, Nonlinear programming without a penalty function, Math. Program. 91, 2002.
#pragma once

#include <algorithm>
#include <vector>

namespace saltus {

class Filter {
 public:
  /// Empties the filter and sets the largest violation that it accepts.
  void reset(double largest_violation) {
    corners_.clear();
    largest_ = largest_violation;
  }
  void add(double violation, double cost) {
    std::erase_if(corners_,
                  [&](const Corner& c) { return c.violation >= violation && c.cost >= cost; });
    corners_.push_back({violation, cost});
  }
  bool accepts(double violation, double cost) const {
    return violation <= largest_ && std::none_of(corners_.begin(), corners_.end(), [&](Corner c) {
             return violation >= c.violation && cost >= c.cost;
           });
  }

 private:
  struct Corner {
    double violation, cost;
  };
  std::vector<Corner> corners_;
  double largest_ = 0.0;
};

}  // namespace saltus
