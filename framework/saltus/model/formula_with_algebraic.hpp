// Adapts a formula of (t, x, z, u, p) to make_function(), which expects z appended to x.
#pragma once

#include "saltus/core/types.hpp"

namespace saltus {

/// Takes (x z) as one vector and calls the formula as f(t, x, z, u, p), f(t, x, z, u), f(t, x, z)
/// or f(t, x).
template <int nx, int nz, class F>
struct FormulaWithAlgebraic {
  F formula;  ///< the user's formula

  /// Splits xz into x and z and calls the formula.
  template <class S, class U, class P>
  auto operator()(const S& t, const Vec<S, nx + nz>& xz, const U& u, const P& p) const {
    Vec<S, nx> x;
    Vec<S, nz> z;
    for (int i = 0; i < nx; ++i) x.data()[i] = xz.data()[i];
    for (int j = 0; j < nz; ++j) z.data()[j] = xz.data()[nx + j];
    if constexpr (requires { formula(t, x, z, u, p); }) {
      return formula(t, x, z, u, p);
    } else if constexpr (requires { formula(t, x, z, u); }) {
      return formula(t, x, z, u);
    } else if constexpr (requires { formula(t, x, z); }) {
      return formula(t, x, z);
    } else if constexpr (requires { formula(t, x); }) {
      return formula(t, x);
    } else {
      static_assert(
          requires { formula(t, x); },
          "a formula with algebraic states must be callable through a const operator() "
          "as f(t, x), f(t, x, z), f(t, x, z, u) or f(t, x, z, u, p), with t a scalar S "
          "and x, z, u, p vectors Vec<S, n> of the declared sizes, for every scalar S");
      return t;
    }
  }
};

}  // namespace saltus
