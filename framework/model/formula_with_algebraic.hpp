// A formula of (t, x, z, u, p) as make_function() takes it, with z behind x.
#pragma once

#include "saltus/core/types.hpp"

namespace saltus {

/// Called with (x z) in one vector; calls the formula as f(t, x, z, u, p), f(t, x, z, u), f(t, x,
/// z) or f(t, x).
template <int nx, int nz, class F>
struct FormulaWithAlgebraic {
  F formula;  ///< of (t, (x, z), u, p)

  /// The formula with the algebraic states found for it.
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
    } else {
      return formula(t, x);
    }
  }
};

}  // namespace saltus
