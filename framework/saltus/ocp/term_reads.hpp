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

/// True if this output of a formula of z = (t | x | u | p) depends on a state and on no input. At a
/// measured state it is fixed, so it is not imposed there.
inline bool reads_states_alone(const Arguments& sizes, const Function& f, int output) {
  const SparsityPattern& pattern = f.jacobian_pattern();
  bool reads_state = false;
  for (int i = 0; i < sizes.nx; ++i)
    reads_state = reads_state || pattern.contains(output, sizes.x(i));
  for (int i = 0; i < sizes.nu; ++i)
    if (pattern.contains(output, sizes.u(i))) return false;
  return reads_state;
}

}  // namespace saltus
