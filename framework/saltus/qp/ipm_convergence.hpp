// Termination criteria of the interior-point method: convergence and stagnation.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include "saltus/qp/ipm_iterate.hpp"
#include "saltus/qp/ipm_residuals.hpp"
#include "saltus/qp/kkt_system.hpp"

namespace saltus::qp {

/// An optimum needs three properties: residuals below the tolerance, rows and bounds satisfied to
/// the tolerance regardless of the multipliers, and a duality gap (the sum of the products) below
/// the tolerance relative to the cost. With large multipliers, rounding may prevent the last
/// digits. The best point that meets the tolerance in units of the multipliers is therefore kept,
/// and returned if the iteration finds no better one.
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

  /// Must be called before each iteration.
  void weigh_multipliers(System& system, const Iterate& p) {
    const double scale = std::fmax(largest_magnitude(p.y, system.equalities()),
                                   largest_magnitude(p.lambda, system.sides()));
    tolerance_ = requested_ * std::clamp(scale / large_multiplier, 1.0, largest_relief);
    acceptable_ = requested_ * std::clamp(scale, 1.0, largest_multiplier);
    has_run_away_ = !(scale <= largest_multiplier);
  }
  /// True if the multipliers are as large as in problems without a solution.
  bool has_diverged() const { return has_run_away_; }
  double tolerance() const { return tolerance_; }
  double acceptable() const { return acceptable_; }
  /// Lower limit of the products: smaller ones only cost digits.
  double least_product(double products) const {
    return std::clamp(gap_of_floor * requested_ / std::fmax(products, 1.0),
                      least_floor * requested_, largest_floor * requested_);
  }

  /// True if the point is optimal. Otherwise keeps the point if it is the best so far.
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

  /// False if nothing has improved for too many iterations, or nothing is left to improve.
  bool goes_on(const Residuals& r) {
    double& least = has_best_ ? least_shortfall_ : least_residual_;
    const double now = has_best_ ? best_shortfall_ : r.largest;
    without_ = now < worthwhile * least ? 0 : without_ + 1;
    least = std::fmin(least, now);
    return std::isfinite(r.largest) && without_ < (has_best_ ? patience_at_end : patience);
  }

  bool has_best() const { return has_best_; }
  /// Swaps the point with the best one.
  void restore(Iterate& p, double& residual, double& feasibility) {
    std::swap(p.v, best_.v);
    std::swap(p.y, best_.y);
    std::swap(p.lambda, best_.lambda);
    residual = best_residual_;
    feasibility = best_feasibility_;
  }

 private:
  static constexpr double infinite = std::numeric_limits<double>::infinity();
  // Rounding prevents a side with a multiplier of 1e6 from being satisfied to 1e-8 / 1e6. Above
  // `large_multiplier` the tolerance grows with the multipliers, up to `largest_multiplier`. Larger
  // multipliers indicate a problem without a solution.
  static constexpr double large_multiplier = 1e4, largest_multiplier = 1e7;
  static constexpr double largest_relief = largest_multiplier / large_multiplier;
  // Fraction of the mean product, so that the largest products do not dominate.
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
