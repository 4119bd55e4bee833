// Where the interior-point method begins.
#pragma once

#include <algorithm>
#include <cmath>

#include "saltus/qp/ipm_iterate.hpp"

namespace saltus::qp {

/// Slacks follow from the sides at v where they are far enough inside, multipliers from the
/// barrier: s lambda = barrier. y starts at zero.
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
    // A soft side starts with a violation that explains the gap, and multipliers in balance.
    point.t[i] = std::max(point.s[i] - gap, least_slack);
    point.s[i] = std::max(gap + point.t[i], least_slack);
    point.lambda[i] = barrier / point.s[i];
    point.tau[i] = std::max(system.l1()[i] + system.l2()[i] * point.t[i] - point.lambda[i],
                            barrier / point.t[i]);
  }
}

/// Mehrotra's start, which needs no guess: the point that meets the sides best in the least-squares
/// sense, its distances to them taken as slacks and, with the other sign, as multipliers, and both
/// shifted until they are positive. The system was factored with weights of 1.
template <class System>
void start_least_squares(System& system, Iterate& point, AlignedArray& work, AlignedArray& gradient,
                         AlignedArray& equality) {
  const int sides = system.sides(), variables = system.variables();
  for (int i = 0; i < variables; ++i) point.v[i] = 0.0;
  for (int i = 0; i < system.equalities(); ++i) point.y[i] = 0.0;
  for (int i = 0; i < sides; ++i) point.lambda[i] = 0.0;
  system.evaluate(point.v.data(), point.y.data(), point.lambda.data(), gradient.data(),
                  equality.data(), work.data());
  system.multiply_transposed(system.beta(), point.v.data());
  for (int i = 0; i < variables; ++i) gradient[i] -= point.v[i];
  system.solve(gradient.data(), equality.data(), point.v.data(), point.y.data());
  system.multiply(point.v.data(), work.data());
  double least = 0.0, most = 0.0;
  for (int i = 0; i < sides; ++i) {
    if (system.active()[i] == 0.0) continue;
    const double gap = work[i] - system.beta()[i];
    least = std::min(least, gap);
    most = std::max(most, gap);
  }
  double slack_shift = -1.5 * least, multiplier_shift = 1.5 * most;
  double products = 0.0, slacks = 0.0, multipliers = 0.0;
  for (int i = 0; i < sides; ++i) {
    if (system.active()[i] == 0.0) continue;
    const double gap = work[i] - system.beta()[i];
    products += (gap + slack_shift) * (multiplier_shift - gap);
    slacks += gap + slack_shift;
    multipliers += multiplier_shift - gap;
  }
  // Where every side holds with ease, or none does, something positive is still needed.
  constexpr double something = 1e-2;
  slack_shift += std::max(0.5 * products / std::max(multipliers, something), something);
  multiplier_shift += std::max(0.5 * products / std::max(slacks, something), something);
  for (int i = 0; i < sides; ++i) {
    const bool active = system.active()[i] != 0.0;
    const double gap = work[i] - system.beta()[i];
    point.s[i] = active ? gap + slack_shift : 1.0;
    point.lambda[i] = active ? multiplier_shift - gap : 0.0;
    point.t[i] = point.tau[i] = 1.0;
    if (i < system.first_soft() || !active) continue;
    point.t[i] = std::max(-gap, 0.0) + slack_shift;
    point.s[i] = gap + point.t[i];
    if (point.s[i] < slack_shift) point.s[i] = slack_shift;
    const double slope = system.l1()[i] + system.l2()[i] * point.t[i];
    point.lambda[i] = 0.5 * slope;
    point.tau[i] = 0.5 * slope;
  }
}

/// Slacks as v leaves them. False where a side is missed, or a product left, by more than the
/// tolerance: v, y and lambda are no optimum then, and the rest is not completed.
template <class System>
bool take_literally(System& system, double tolerance, Iterate& point, AlignedArray& work) {
  system.multiply(point.v.data(), work.data());
  for (int i = 0; i < system.sides(); ++i) {
    const bool active = system.active()[i] != 0.0;
    const bool soft = i >= system.first_soft() && active;
    const double gap = work[i] - system.beta()[i];
    point.s[i] = point.t[i] = point.tau[i] = 1.0;
    if (!active) continue;
    point.s[i] = std::max(gap, 0.0);
    if (point.s[i] * point.lambda[i] > tolerance || (!soft && gap < -tolerance)) return false;
    if (!soft) continue;
    point.t[i] = std::max(-gap, 0.0);
    point.tau[i] = std::max(system.l1()[i] + system.l2()[i] * point.t[i] - point.lambda[i], 0.0);
    if (point.t[i] * point.tau[i] > tolerance) return false;
  }
  return true;
}

/// Keeps v, y and lambda of a neighbouring problem; slack and multiplier of every side are lifted
/// just enough for their product to reach the barrier.
template <class System>
void lift_products(System& system, double barrier, Iterate& point, AlignedArray& work) {
  const double least = std::sqrt(barrier);
  system.multiply(point.v.data(), work.data());
  for (int i = 0; i < system.sides(); ++i) {
    const bool active = system.active()[i] != 0.0;
    double gap = work[i] - system.beta()[i];
    const bool soft = i >= system.first_soft() && active;
    point.t[i] = point.tau[i] = 1.0;
    if (soft) {
      point.t[i] = std::max(-gap, least);
      gap += point.t[i];
    }
    double s = active ? std::max(gap, 0.0) : 1.0;
    double lambda = active ? std::max(point.lambda[i], 0.0) : 0.0;
    if (active && s * lambda < barrier) {
      if (s > lambda) {
        lambda = std::max(lambda, barrier / std::max(s, least));
        s = std::max(s, least);
      } else {
        s = std::max(s, barrier / std::max(lambda, least));
        lambda = std::max(lambda, least);
      }
    }
    point.s[i] = s;
    point.lambda[i] = lambda;
    if (soft)
      point.tau[i] =
          std::max(system.l1()[i] + system.l2()[i] * point.t[i] - lambda, barrier / point.t[i]);
  }
}

/// Mean over the sides of |gap x multiplier|: zero where one of the two vanishes, as at an optimum.
template <class System>
double mean_mismatch(System& system, const Iterate& point, AlignedArray& work) {
  system.multiply(point.v.data(), work.data());
  double total = 0.0, count = 0.0;
  for (int i = 0; i < system.sides(); ++i) {
    total += std::fabs((work[i] - system.beta()[i]) * point.lambda[i]) * system.active()[i];
    count += system.active()[i];
  }
  return count > 0.0 ? total / count : 0.0;
}

}  // namespace saltus::qp
