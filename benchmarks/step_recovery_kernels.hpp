// The sizes of the step-recovery program as compile-time constants: 9 states, and 6 inputs with one
// foot or two, whose wrenches have a common resultant. The start is fixed (no states in its stage),
// and the end has no inputs.
#pragma once

#include "saltus/qp/riccati_kernels.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

// 12 inputs: if the solver does not use the resultant.
inline constexpr qp::RiccatiKernel step_recovery_kernels[] = {
    qp::riccati_kernel<9, 6, 9>(), qp::riccati_kernel<0, 6, 9>(), qp::riccati_kernel<9, 0, 0>(),
    qp::riccati_kernel<9, 12, 9>(), qp::riccati_kernel<0, 12, 9>()};

/// Cold starts at the static wrench and the resulting states.
inline qp::RiccatiOptions from_standing() {
  qp::RiccatiOptions options;
  options.start = qp::QpOptions::Start::guess;
  options.roll_out = true;
  return options;
}

}  // namespace saltus::bench
