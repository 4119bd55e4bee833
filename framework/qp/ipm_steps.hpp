// How far the interior-point method goes along its direction.
#pragma once

#include <algorithm>

#include "framework/qp/ipm_iterate.hpp"

namespace saltus::qp {

/// Where x + a dx stays positive, a <= 1 / largest(-dx / x).
inline Lanes shrink_rate(const AlignedArray& x, const AlignedArray& dx, int i) {
  return -load(&dx[i]) / load(&x[i]);
}

/// Step lengths of v, s, t and of y, lambda, tau.
struct StepLengths {
  double primal = 1.0, dual = 1.0;
};

/// Longest steps that keep s and t, lambda and tau non-negative; may exceed 1.
inline StepLengths largest_steps(const Iterate& p, const Iterate& step, int first_soft, int sides) {
  Lanes primal{}, dual{};
  for (int i = 0; i < sides; i += lanes) {
    primal = larger(primal, shrink_rate(p.s, step.s, i));
    // Padding has lambda = 0, and does not move.
    const Lanes lambda = load(&p.lambda[i]);
    dual = larger(dual, -load(&step.lambda[i]) / larger(lambda, broadcast(1e-300)));
  }
  for (int i = first_soft; i < sides; i += lanes) {
    primal = larger(primal, shrink_rate(p.t, step.t, i));
    dual = larger(dual, shrink_rate(p.tau, step.tau, i));
  }
  const auto length = [](double rate) { return rate > 0.0 ? 1.0 / rate : 1e300; };
  return {length(largest(primal)), length(largest(dual))};
}

/// The length of the step that is taken: not quite to the boundary, closer to it as the optimum
/// nears, and the same for both, so that every linear residual shrinks by the same share.
inline double damped_step(const Iterate& p, const Iterate& step, int first_soft, int sides,
                          double mu) {
  const double fraction = std::clamp(1.0 - mu, 0.995, 0.9999);
  const StepLengths longest = largest_steps(p, step, first_soft, sides);
  return std::min(1.0, fraction * std::min(longest.primal, longest.dual));
}

}  // namespace saltus::qp
