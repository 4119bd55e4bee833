// How far the interior-point method goes along its direction.
#pragma once

#include <algorithm>

#include "framework/qp/ipm_iterate.hpp"

namespace saltus::qp {

/// Where x + a dx stays positive, a <= 1 / largest(-dx / x).
inline Lanes shrink_rate(const AlignedArray& x, const AlignedArray& dx, int i) {
  return -load(&dx[i]) / load(&x[i]);
}

/// Longest step that keeps s, lambda, t and tau non-negative; may exceed 1.
inline double largest_step(const Iterate& p, const Iterate& step, int first_soft, int sides) {
  Lanes rate{};
  for (int i = 0; i < sides; i += lanes) {
    rate = larger(rate, shrink_rate(p.s, step.s, i));
    // Padding has lambda = 0: compare products instead of dividing.
    const Lanes lambda = load(&p.lambda[i]);
    rate = larger(rate, -load(&step.lambda[i]) / larger(lambda, broadcast(1e-300)));
  }
  for (int i = first_soft; i < sides; i += lanes)
    rate = larger(rate, larger(shrink_rate(p.t, step.t, i), shrink_rate(p.tau, step.tau, i)));
  const double worst = largest(rate);
  return worst > 0.0 ? 1.0 / worst : 1e300;
}

/// The step that is taken: not quite to the boundary, closer to it as the optimum nears.
inline double damped_step(const Iterate& p, const Iterate& step, int first_soft, int sides,
                          double mu) {
  const double fraction = std::max(0.995, 1.0 - mu);
  return std::min(1.0, fraction * largest_step(p, step, first_soft, sides));
}

}  // namespace saltus::qp
