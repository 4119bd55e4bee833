// Steps of descent where the Hessian is indefinite: the smallest shift that makes it convex.
//
// At a local solution H + G'WG is convex where E v = 0, because the weights W of the sides that
// hold grow without limit. On the way there it may not be: Newton's step would then lead towards a
// saddle. H + shift I with a shift that is large enough leads down; how large that is the inertia
// of the factor tells. The shift changes steps, and not the point to which they converge.
//
// Waechter and Biegler, On the implementation of an interior-point filter line-search algorithm for
// large-scale nonlinear programming, Math. Program. 106, 2006, sec. 3.1.
#pragma once

#include <algorithm>

namespace saltus::qp {

class InertiaCorrection {
 public:
  /// Of convex programs the shift is zero, and what breaks down is not tried again.
  void reset(bool convex) {
    convex_ = convex;
    shift_ = last_ = 0.0;
  }
  double shift() const { return shift_; }

  /// Calls factor(shift) with growing shifts until it says true.
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
  // Those of the paper, for Hessians scaled to about 1; larger ones take a few factors more.
  static constexpr double first = 1e-4, least = 1e-12, most = 1e15, fast = 100.0, slow = 8.0;

  bool convex_ = true;
  double shift_ = 0.0, last_ = 0.0;
};

}  // namespace saltus::qp
