// Claims that a solution makes about itself.
#pragma once

#include <type_traits>

namespace saltus::corpus {

/// True if the solution claims that its second derivatives are those of a minimum.
template <class S>
bool claims_minimum(const S& solution) {
  if constexpr (requires { solution.curvature_checked; })
    return solution.curvature_checked;
  else
    return solution.curvature == std::decay_t<decltype(solution.curvature)>::minimum;
}

/// Stated factor by which an error at the start grows. Zero if the solution states none.
template <class S>
double stated_growth(const S& solution) {
  if constexpr (requires { solution.verification; })
    return solution.verification ? solution.verification->open_loop.growth : 0.0;
  else
    return 0.0;
}

}  // namespace saltus::corpus
