// Dependence of the outputs of a formula on its arguments.
#pragma once

#include "saltus/model/function.hpp"

namespace saltus {

/// True if the formula depends on one of `count` arguments from `first` on.
inline bool reads_any(const Function& f, int first, int count) {
  for (int i = first; i < first + count; ++i)
    if (f.reads(i)) return true;
  return false;
}

/// True if this output of a formula of z = (t | x | u | p) depends on a state.
inline bool reads_state(const Arguments& sizes, const Function& f, int output) {
  const SparsityPattern& pattern = f.jacobian_pattern();
  for (int i = 0; i < sizes.nx; ++i)
    if (pattern.contains(output, sizes.x(i))) return true;
  return false;
}

}  // namespace saltus
