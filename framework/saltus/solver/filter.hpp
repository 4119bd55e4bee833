// The filter by which points are accepted: whoever is worse than a point in it both in violation
// and in cost is refused.
//
// Fletcher and Leyffer, Nonlinear programming without a penalty function, Math. Program. 91, 2002.
#pragma once

#include <algorithm>
#include <vector>

namespace saltus {

class Filter {
 public:
  /// Nothing with a larger violation is accepted.
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
