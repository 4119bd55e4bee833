// When the interior-point method has arrived, and when it will not get any further.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "saltus/qp/ipm_iterate.hpp"
#include "saltus/qp/ipm_residuals.hpp"
#include "saltus/qp/kkt_system.hpp"

namespace saltus::qp {

/// Three things are asked of an optimum: residuals below the tolerance, rows and bounds met to the
/// tolerance whatever the multipliers are, and a duality gap, the sum of the products, below the
/// tolerance relative to the cost. Rounding may forbid the last digits where multipliers are large:
/// the best point that meets the tolerance in units of the multipliers is kept, and is the answer
/// if nothing better comes.
template <KktSystem System>
class Convergence {
 public:
  Convergence(int variables, int equalities, int sides) : best_(variables, equalities, sides) {}

  void reset(double tolerance) {
    requested_ = tolerance_ = acceptable_ = tolerance;
    least_residual_ = least_shortfall_ = best_shortfall_ = infinite;
    without_ = 0;
    has_best_ = false;
  }

  /// To be told before each iteration.
  void weigh_multipliers(System& system, const Iterate& p) {
    const double scale = std::fmax(largest_magnitude(p.y, system.equalities()),
                                   largest_magnitude(p.lambda, system.sides()));
    tolerance_ = requested_ * std::clamp(scale / large_multiplier, 1.0, largest_relief);
    acceptable_ = requested_ * std::clamp(scale, 1.0, largest_multiplier);
    has_run_away_ = !(scale <= largest_multiplier);
  }
  /// Whether multipliers are as large as those of problems without a solution.
  bool has_run_away() const { return has_run_away_; }
  double tolerance() const { return tolerance_; }
  double acceptable() const { return acceptable_; }
  /// Products are not driven further down than this: it would only cost digits.
  double least_product(double products) const {
    return std::clamp(gap_of_floor * requested_ / std::fmax(products, 1.0),
                      least_floor * requested_, largest_floor * requested_);
  }

  /// Whether this is the optimum; if not, the point is kept where it is the best so far.
  bool reached(System& system, const Iterate& p, const ResidualTracker<System>& tracker) {
    const Residuals& r = tracker.at_point();
    if (!tracker.exact() || !(r.largest <= acceptable_) || r.feasibility > requested_) return false;
    const double gap = r.mu * tracker.products();
    double allowed = gap_fraction * requested_;
    if (gap > allowed) allowed *= std::fmax(1.0, std::fabs(system.cost(p.v.data())));
    const double shortfall =
        std::fmax(std::fmax(r.largest, r.mu / enough_on_average) / tolerance_, gap / allowed);
    if (shortfall <= 1.0) return true;
    if (!(shortfall < best_shortfall_)) return false;
    best_shortfall_ = shortfall;
    best_residual_ = r.largest;
    best_feasibility_ = r.feasibility;
    has_best_ = true;
    std::copy_n(p.v.data(), system.variables(), best_.v.data());
    std::copy_n(p.y.data(), system.equalities(), best_.y.data());
    std::copy_n(p.lambda.data(), system.sides(), best_.lambda.data());
    return false;
  }

  /// False when nothing has improved for too long, or nothing is left to improve.
  bool goes_on(const Residuals& r) {
    double& least = has_best_ ? least_shortfall_ : least_residual_;
    const double now = has_best_ ? best_shortfall_ : r.largest;
    without_ = now < worthwhile * least ? 0 : without_ + 1;
    least = std::fmin(least, now);
    return std::isfinite(r.largest) && without_ < (has_best_ ? patience_at_end : patience);
  }

  bool has_best() const { return has_best_; }
  /// Exchanges the point for the best one.
  void restore(Iterate& p, double& residual, double& feasibility) {
    std::swap(p.v, best_.v);
    std::swap(p.y, best_.y);
    std::swap(p.lambda, best_.lambda);
    residual = best_residual_;
    feasibility = best_feasibility_;
  }

 private:
  static constexpr double infinite = std::numeric_limits<double>::infinity();
  // A side with a multiplier of a million cannot be met to 1e-8 / 1e6: rounding forbids it. Beyond
  // the first size the tolerance grows with the multipliers, up to the second. Multipliers beyond
  // that are those of a problem without a solution.
  static constexpr double large_multiplier = 1e4, largest_multiplier = 1e7;
  static constexpr double largest_relief = largest_multiplier / large_multiplier;
  // Of the mean product, so that the largest ones are not all there are.
  static constexpr double enough_on_average = 1e-2;
  static constexpr double gap_fraction = 0.3, gap_of_floor = 0.1;
  static constexpr double least_floor = 1e-5, largest_floor = 2e-3;
  static constexpr int patience = 20, patience_at_end = 6;
  static constexpr double worthwhile = 0.5;

  Iterate best_;
  double requested_ = 1e-8, tolerance_ = 1e-8, acceptable_ = 1e-8;
  double least_residual_ = infinite, least_shortfall_ = infinite;
  double best_shortfall_ = infinite, best_residual_ = 0.0, best_feasibility_ = 0.0;
  int without_ = 0;
  bool has_best_ = false, has_run_away_ = false;
};

}  // namespace saltus::qp
