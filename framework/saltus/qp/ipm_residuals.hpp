// Residuals of the optimality conditions along the iterates of the interior-point method.
#pragma once

#include <cmath>
#include <limits>

#include "saltus/qp/ipm_iterate.hpp"
#include "saltus/qp/kkt_system.hpp"

namespace saltus::qp {

inline double largest_magnitude(const AlignedArray& a, int size) {
  Lanes result{};
  for (int i = 0; i < size; i += lanes) result = larger(result, magnitude(load(&a[i])));
  return largest(result);
}

template <KktSystem System>
class ResidualTracker {
 public:
  ResidualTracker(int variables, int equalities, int sides)
      : residuals_(variables, equalities, sides) {}

  const Residuals& at_point() const { return residuals_; }
  /// True if the residuals were evaluated at the point, false if they were extrapolated from the
  /// steps.
  bool exact() const { return trusted_steps_ == 0; }

  void reset(System& system) {
    trusted_steps_ = 0;
    known_ = lost_digits_ = false;
    Lanes active{}, furthest{};
    for (int i = 0; i < system.sides(); i += lanes) {
      active += load(system.active() + i) * (i < system.first_soft() ? 1.0 : 2.0);
      furthest = larger(furthest, magnitude(load(system.beta() + i)));
    }
    products_ = sum(active);
    has_far_sides_ = digits_of_side * largest(furthest) > rounding;
  }
  /// Declares that the next step does not reduce residuals as follow() assumes.
  void distrust() { known_ = false; }
  /// True if a step left rows with a larger violation than predicted: digits were lost.
  bool lost_digits() const { return lost_digits_; }
  /// Number of products s lambda and t tau.
  double products() const { return products_; }

  /// Updates the residuals after a step of this length, which leaves (1 - length) of every linear
  /// residual. Far from the optimum this prediction is used; near it the residuals are evaluated.
  void follow(System& system, const Iterate& p, double length, double nearly_solved) {
    measure_products(system, p);
    const bool far = !lost_digits_ && residuals_.largest_product > nearly_solved &&
                     trusted_steps_ < longest_trust;
    if (far && known_) {
      ++trusted_steps_;
      const double left = 1.0 - length;
      shrink(residuals_.stationarity, left, 0, system.variables());
      shrink(residuals_.equality, left, 0, system.equalities());
      shrink(residuals_.side, left, 0, system.sides());
      shrink(residuals_.soft, left, system.first_soft(), system.sides());
      residuals_.feasibility *= left;
      stationary_ *= left;
      find_largest();
    } else {
      const double expected = (1.0 - length) * residuals_.feasibility;
      const bool known = known_;
      evaluate(system, p);
      if (known && residuals_.feasibility > unexpected * expected + rounding) lost_digits_ = true;
    }
  }

  /// Evaluates the residuals at the point.
  void evaluate(System& system, const Iterate& p) {
    Residuals& r = residuals_;
    trusted_steps_ = 0;
    known_ = true;
    system.evaluate(p.v.data(), p.y.data(), p.lambda.data(), r.stationarity.data(),
                    r.equality.data(), r.side.data());
    for (int i = 0; i < system.first_soft(); i += lanes)
      store(&r.side[i], (load(&r.side[i]) - load(system.beta() + i) - load(&p.s[i])) *
                            load(system.active() + i));
    for (int i = system.first_soft(); i < system.sides(); i += lanes) {
      const Lanes active = load(system.active() + i), t = load(&p.t[i]);
      store(&r.side[i], (load(&r.side[i]) - load(system.beta() + i) + t - load(&p.s[i])) * active);
      store(&r.soft[i], (load(system.l1() + i) + load(system.l2() + i) * t - load(&p.lambda[i]) -
                         load(&p.tau[i])) *
                            active);
    }
    measure(system);
  }

 private:
  static constexpr int longest_trust = 6;
  static constexpr double unexpected = 2.0, rounding = 1e-10;
  // Rounding error of a residual relative to its side: two units in the last place.
  static constexpr double digits_of_side = 4.0 * std::numeric_limits<double>::epsilon();

  void measure_products(System& system, const Iterate& p) {
    Lanes most{}, total{};
    for (int i = 0; i < system.sides(); i += lanes) {
      const Lanes product = load(&p.s[i]) * load(&p.lambda[i]);
      most = larger(most, product);
      total += product;
    }
    for (int i = system.first_soft(); i < system.sides(); i += lanes) {
      const Lanes product = load(&p.t[i]) * load(&p.tau[i]) * load(system.active() + i);
      most = larger(most, product);
      total += product;
    }
    residuals_.largest_product = largest(most);
    residuals_.mu = products_ > 0.0 ? sum(total) / products_ : 0.0;
  }

  void measure(System& system) {
    Residuals& r = residuals_;
    r.feasibility = std::fmax(has_far_sides_ ? largest_beyond_rounding(system)
                                             : largest_magnitude(r.side, system.sides()),
                              largest_magnitude(r.equality, system.equalities()));
    Lanes most{}, total{};
    for (int i = system.first_soft(); i < system.sides(); i += lanes)
      most = larger(most, magnitude(load(&r.soft[i])));
    for (int i = 0; i < system.variables(); i += lanes) {
      const Lanes slope = load(&r.stationarity[i]);
      most = larger(most, magnitude(slope));
      total += slope;
    }
    // A maximum ignores NaN; adding 0 x sum propagates it.
    stationary_ = largest(most) + 0.0 * sum(total);
    find_largest();
  }

  // Largest residual of the sides, without the rounding error of a side.
  double largest_beyond_rounding(System& system) const {
    Lanes most{};
    for (int i = 0; i < system.sides(); i += lanes)
      most = larger(most, magnitude(load(&residuals_.side[i])) -
                              magnitude(load(system.beta() + i)) * digits_of_side);
    return largest(most);
  }

  void find_largest() {
    Residuals& r = residuals_;
    r.largest = std::fmax(std::fmax(r.feasibility, r.largest_product), stationary_);
    r.largest += 0.0 * (r.mu + stationary_);
  }

  static void shrink(AlignedArray& a, double factor, int first, int last) {
    for (int i = first; i < last; i += lanes) store(&a[i], load(&a[i]) * factor);
  }

  Residuals residuals_;
  double products_ = 0.0;
  double stationary_ = 0.0;  ///< largest entry of stationarity and soft
  int trusted_steps_ = 0;
  bool known_ = false, lost_digits_ = false, has_far_sides_ = false;
};

}  // namespace saltus::qp
