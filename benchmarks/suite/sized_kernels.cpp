#include "benchmarks/suite/sized_kernels.hpp"

#include "benchmarks/step_recovery_kernels.hpp"

namespace saltus::bench {

std::span<const qp::RiccatiKernel> sized_kernels() { return step_recovery_kernels; }

}  // namespace saltus::bench
