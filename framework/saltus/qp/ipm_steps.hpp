// Step lengths of the interior-point method.
#pragma once

#include <algorithm>

#include "saltus/qp/ipm_iterate.hpp"

namespace saltus::qp {

/// x + a dx stays positive for a <= 1 / largest(-dx / x).
inline Lanes shrink_rate(const AlignedArray& x, const AlignedArray& dx, int i) {
  return -load(&dx[i]) / load(&x[i]);
}

/// Longest step that keeps s, t, lambda and tau non-negative; may exceed 1.
inline double largest_step(const Iterate& p, const Iterate& step, int first_soft, int sides) {
  Lanes rate{};
  for (int i = 0; i < sides; i += lanes) {
    // Padding has lambda = 0 and does not move.
    const Lanes lambda = larger(load(&p.lambda[i]), broadcast(1e-300));
    rate = larger(rate, larger(shrink_rate(p.s, step.s, i), -load(&step.lambda[i]) / lambda));
  }
  for (int i = first_soft; i < sides; i += lanes)
    rate = larger(rate, larger(shrink_rate(p.t, step.t, i), shrink_rate(p.tau, step.tau, i)));
  const double most = largest(rate);
  return most > 0.0 ? 1.0 / most : 1e300;
}

/// Length of the step: it stops short of the boundary, and closer to it as mu decreases. It is the
/// same for v and y, so that every linear residual shrinks by the same fraction.
inline double damped_step(const Iterate& p, const Iterate& step, int first_soft, int sides,
                          double mu) {
  const double fraction = std::clamp(1.0 - mu, 0.995, 0.9999);
  return std::min(1.0, fraction * largest_step(p, step, first_soft, sides));
}

}  // namespace saltus::qp
