// The kernels of fixed sizes for the step recovery, compiled once for the suite.
#pragma once

#include <span>

namespace saltus::qp {
struct RiccatiKernel;
}

namespace saltus::bench {

std::span<const qp::RiccatiKernel> sized_kernels();

}  // namespace saltus::bench
