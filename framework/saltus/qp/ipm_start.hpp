// Starting points of the interior-point method.
#pragma once

#include <algorithm>
#include <cmath>

#include "saltus/qp/ipm_iterate.hpp"

namespace saltus::qp {

/// Slacks are the distances to the sides at v where v is far enough inside. Multipliers follow from
/// s lambda = barrier. y starts at zero.
template <class System>
void start_at_guess(System& system, double barrier, Iterate& point, AlignedArray& work) {
  const double least_slack = std::sqrt(barrier);
  system.multiply(point.v.data(), work.data());
  for (int i = 0; i < system.equalities(); ++i) point.y[i] = 0.0;
  for (int i = 0; i < system.sides(); ++i) {
    const bool active = system.active()[i] != 0.0;
    const double gap = work[i] - system.beta()[i];
    point.s[i] = active ? std::max(gap, least_slack) : 1.0;
    point.lambda[i] = active ? barrier / point.s[i] : 0.0;
    point.t[i] = point.tau[i] = 1.0;
    if (i < system.first_soft() || !active) continue;
    // The initial violation of a soft side covers the gap, and its multipliers balance.
    point.t[i] = std::max(point.s[i] - gap, least_slack);
    point.s[i] = std::max(gap + point.t[i], least_slack);
    point.lambda[i] = barrier / point.s[i];
    point.tau[i] = std::max(system.l1()[i] + system.l2()[i] * point.t[i] - point.lambda[i],
                            barrier / point.t[i]);
  }
}

/// Weights of the sides in start_least_squares(): 1, or 0 for inactive sides and for sides that
/// hold at v = 0 by far more than other rows require. Bounds that never become active must not
/// influence the start.
template <class System>
void weigh_sides(System& system, AlignedArray& weights) {
  constexpr double idle = 1e5;
  system.row_sizes(weights.data());
  double asked = 1.0;  // largest distance from v = 0 to a side, in units of the variables
  for (int i = 0; i < system.sides(); ++i)
    if (system.active()[i] != 0.0 && weights[i] > 0.0)
      asked = std::max(asked, system.beta()[i] / weights[i]);
  for (int i = 0; i < system.sides(); ++i) {
    const bool is_idle = -system.beta()[i] > idle * asked * std::max(1.0, weights[i]);
    weights[i] = is_idle ? 0.0 : system.active()[i];
  }
}

/// Mehrotra's start, which needs no guess: the least-squares solution of all sides. Its distances
/// to the sides give the slacks and, with reversed sign, the multipliers. Both are shifted until
/// they are positive. The system must be factored with `weights`, see weigh_sides().
template <class System>
void start_least_squares(System& system, const AlignedArray& weights, Iterate& point,
                         AlignedArray& work, AlignedArray& gradient, AlignedArray& equality) {
  const int sides = system.sides(), variables = system.variables();
  for (int i = 0; i < variables; ++i) point.v[i] = 0.0;
  for (int i = 0; i < system.equalities(); ++i) point.y[i] = 0.0;
  for (int i = 0; i < sides; ++i) point.lambda[i] = 0.0;
  system.evaluate(point.v.data(), point.y.data(), point.lambda.data(), gradient.data(),
                  equality.data(), work.data());
  for (int i = 0; i < sides; ++i) work[i] = weights[i] != 0.0 ? system.beta()[i] : 0.0;
  system.add_transposed(work.data(), point.v.data());
  for (int i = 0; i < variables; ++i) gradient[i] -= point.v[i];
  system.solve(gradient.data(), equality.data(), point.v.data(), point.y.data());
  system.multiply(point.v.data(), work.data());
  double least = 0.0, most = 0.0;
  for (int i = 0; i < sides; ++i) {
    if (weights[i] == 0.0) continue;
    const double gap = work[i] - system.beta()[i];
    least = std::min(least, gap);
    most = std::max(most, gap);
  }
  double slack_shift = -1.5 * least, multiplier_shift = 1.5 * most;
  double products = 0.0, slacks = 0.0, multipliers = 0.0;
  for (int i = 0; i < sides; ++i) {
    if (weights[i] == 0.0) continue;
    const double gap = work[i] - system.beta()[i];
    products += (gap + slack_shift) * (multiplier_shift - gap);
    slacks += gap + slack_shift;
    multipliers += multiplier_shift - gap;
  }
  // Lower limit of the shift, also if all sides hold easily or none holds.
  constexpr double something = 1e-2;
  slack_shift += std::max(0.5 * products / std::max(multipliers, something), something);
  multiplier_shift += std::max(0.5 * products / std::max(slacks, something), something);
  for (int i = 0; i < sides; ++i) {
    const bool active = system.active()[i] != 0.0;
    const double gap = work[i] - system.beta()[i];
    point.s[i] = active ? gap + slack_shift : 1.0;
    point.lambda[i] = active ? multiplier_shift - gap : 0.0;
    point.t[i] = point.tau[i] = 1.0;
    const bool is_idle = active && weights[i] == 0.0 && gap > slack_shift;
    if (is_idle) {
      point.s[i] = gap;
      point.lambda[i] = slack_shift * multiplier_shift / gap;
    }
    if (i < system.first_soft() || !active) continue;
    point.t[i] = std::max(-gap, 0.0) + slack_shift;
    point.s[i] = gap + point.t[i];
    if (point.s[i] < slack_shift) point.s[i] = slack_shift;
    const double slope = system.l1()[i] + system.l2()[i] * point.t[i];
    point.lambda[i] = is_idle ? std::min(0.5 * slope, point.lambda[i]) : 0.5 * slope;
    point.tau[i] = slope - point.lambda[i];
  }
}

/// Computes the slacks from v. Returns false if a side is violated or a product left by more than
/// the tolerance: v, y and lambda are then not optimal. `values`: G v.
template <class System>
bool slacks_from_values(System& system, double tolerance, const AlignedArray& values,
                        Iterate& point) {
  const Lanes one = broadcast(1.0);
  Lanes worst{};
  for (int i = 0; i < system.sides(); i += lanes) {
    const Lanes active = load(system.active() + i), lambda = load(&point.lambda[i]);
    const Lanes gap = load(&values[i]) - load(system.beta() + i), slack = larger(gap, Lanes{});
    const bool soft = i >= system.first_soft();
    store(&point.s[i], active > 0.0 ? slack : one);
    worst = larger(worst, (soft ? slack * lambda : larger(slack * lambda, -gap)) * active);
    Lanes t = one, tau = one;
    if (soft) {
      t = larger(-gap, Lanes{});
      tau = larger(load(system.l1() + i) + load(system.l2() + i) * t - lambda, Lanes{});
      worst = larger(worst, t * tau * active);
    }
    store(&point.t[i], active > 0.0 ? t : one);
    store(&point.tau[i], active > 0.0 ? tau : one);
  }
  return largest(worst) <= tolerance;
}

/// Keeps v, y and lambda of a neighbouring problem. Slacks are raised until their products reach
/// the barrier, but at most to a tenth of the row's coefficients; then multipliers are raised
/// likewise. On soft sides, violations and their multipliers are set first. The barrier starts at
/// `least_barrier` and grows with the multipliers. `values`: G v. `size`: work space that receives
/// the norms of the rows.
///
/// Active and inactive sides stay separated by orders of magnitude. If the active set is unchanged,
/// two or three steps suffice; if it changes, few slacks need correction.
template <class System>
void start_warm(System& system, double least_barrier, const AlignedArray& values, Iterate& point,
                AlignedArray& size) {
  constexpr double barrier_per_multiplier = 3e-4;    // per unit of the row
  constexpr double largest_slack = 0.1;              // per unit of the row
  constexpr double product_of_slack = 3.0;           // in units of the barrier
  const Lanes least_multiplier = broadcast(1e-100);  // avoids division by zero
  const Lanes one = broadcast(1.0);
  system.row_sizes(size.data());
  Lanes most{};
  for (int i = 0; i < system.sides(); i += lanes)
    most = larger(most, load(&point.lambda[i]) * load(&size[i]) * load(system.active() + i));
  const Lanes barrier = broadcast(std::max(least_barrier, barrier_per_multiplier * largest(most)));
  const auto lifted = [&](const Lanes& slack, const Lanes& multiplier, const Lanes& row) {
    const Lanes wanted = product_of_slack * barrier / larger(multiplier, least_multiplier);
    return larger(slack, smaller(wanted, largest_slack * (row > 0.0 ? row : one)));
  };
  for (int i = 0; i < system.sides(); i += lanes) {
    const Lanes active = load(system.active() + i), row = load(&size[i]);
    const Lanes multiplier = load(&point.lambda[i]);
    Lanes gap = load(&values[i]) - load(system.beta() + i), t = one, tau = one;
    if (i >= system.first_soft()) {
      const Lanes violation = larger(-gap, Lanes{});
      const Lanes slope = load(system.l1() + i) + load(system.l2() + i) * violation - multiplier;
      tau = larger(slope, Lanes{});
      t = lifted(violation, tau, row);
      tau = larger(tau, barrier / t);
      gap += t;
    }
    const Lanes s = lifted(gap, multiplier, row), lambda = larger(multiplier, barrier / s);
    store(&point.s[i], active > 0.0 ? s : one);
    store(&point.lambda[i], active > 0.0 ? lambda : Lanes{});
    store(&point.t[i], active > 0.0 ? t : one);
    store(&point.tau[i], active > 0.0 ? tau : one);
  }
}

}  // namespace saltus::qp
