// Kernels of fixed sizes for our families of programs, compiled once for the suite.
#pragma once

#include <span>

namespace saltus::qp {
struct RiccatiKernel;
}

namespace saltus::bench {

std::span<const qp::RiccatiKernel> sized_kernels();  ///< kernels of the step recovery
std::span<const qp::RiccatiKernel> chain_sizes();
std::span<const qp::RiccatiKernel> car_sizes();

}  // namespace saltus::bench
