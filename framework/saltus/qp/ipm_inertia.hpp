// Descent steps for an indefinite Hessian: the smallest shift that makes it convex.
//
// At a local solution H + G'WG is convex where E v = 0, because the weights W of active sides grow
// without limit. Before that it may be indefinite, and Newton's step would lead towards a saddle. H
// + shift I with a large enough shift gives a descent direction. The inertia of the factor shows
// whether the shift is large enough. The shift changes the steps, not the point to which they
// converge.
//
// Waechter and Biegler, On the implementation of an interior-point filter line-search algorithm for
// large-scale nonlinear programming, Math. Program. 106, 2006, sec. 3.1.
#pragma once

#include <algorithm>

namespace saltus::qp {

class InertiaCorrection {
 public:
  /// For convex programs the shift is zero and a breakdown is not retried.
  void reset(bool convex) {
    convex_ = convex;
    shift_ = last_ = 0.0;
  }
  double shift() const { return shift_; }

  /// Calls factor(shift) with growing shifts until it returns true.
  template <class Factor>
  bool correct(Factor factor) {
    shift_ = 0.0;
    if (factor(shift_)) return true;
    if (convex_) return false;
    const double growth = last_ == 0.0 ? fast : slow;
    shift_ = last_ == 0.0 ? first : std::max(least, last_ / 3.0);
    for (; shift_ <= most; shift_ *= growth) {
      if (!factor(shift_)) continue;
      last_ = shift_;
      return true;
    }
    return false;
  }

 private:
  // Values of the paper, for Hessians scaled to about 1. Larger Hessians need a few more
  // factorisations.
  static constexpr double first = 1e-4, least = 1e-12, most = 1e15, fast = 100.0, slow = 8.0;

  bool convex_ = true;
  double shift_ = 0.0, last_ = 0.0;
};

}  // namespace saltus::qp
