// Switches in a formula: exact (select) or smooth over a width (smooth_*).
#pragma once

#include "saltus/autodiff/math.hpp"

namespace saltus {

/// `a` if condition >= 0, else `b` (also if the condition is NaN). The derivative is that of the
/// chosen branch. The sparsity includes both branches and the condition.
template <Scalar C, Scalar A, Scalar B>
CommonScalar<C, A, B> select(const C& condition, const A& a, const B& b) {
  using S = CommonScalar<C, A, B>;
  if constexpr (requires { S::select(S(condition), S(a), S(b)); }) {
    return S::select(S(condition), S(a), S(b));  // the tracer has no values
  } else {
    return primal(condition) >= 0.0 ? S(a) : S(b);
  }
}

/// Rises from 0 to 1 around x = 0: (1 + tanh(x / width)) / 2. Within 1e-4 of 0 or 1 for |x| >= 4.6
/// widths. The width has the unit of x and must be positive.
template <Scalar S>
CommonScalar<S> smooth_step(const S& x, double width) {
  return 0.5 * (1.0 + tanh(x / width));
}

/// sqrt(x^2 + width^2). Exceeds |x| by at most `width`, reached at x = 0.
template <Scalar S>
CommonScalar<S> smooth_abs(const S& x, double width) {
  return sqrt(x * x + width * width);
}

/// Exceeds max(a, b) by at most width / 2, reached at a = b.
template <Scalar A, Scalar B>
CommonScalar<A, B> smooth_max(const A& a, const B& b, double width) {
  using S = CommonScalar<A, B>;
  return 0.5 * (a + b + smooth_abs(S(a - b), width));
}

/// Below min(a, b) by at most width / 2, reached at a = b.
template <Scalar A, Scalar B>
CommonScalar<A, B> smooth_min(const A& a, const B& b, double width) {
  using S = CommonScalar<A, B>;
  return 0.5 * (a + b - smooth_abs(S(a - b), width));
}

}  // namespace saltus
