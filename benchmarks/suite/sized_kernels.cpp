#include "benchmarks/suite/sized_kernels.hpp"

#include "benchmarks/step_recovery_kernels.hpp"

namespace saltus::bench {

namespace {

// Sizes of the chain and the car; the fixed start has no states, the end no inputs.
constexpr qp::RiccatiKernel chain_kernels[] = {qp::riccati_kernel<21, 3, 21>(),
                                               qp::riccati_kernel<0, 3, 21>(),
                                               qp::riccati_kernel<21, 0, 0>()};
constexpr qp::RiccatiKernel car_kernels[] = {
    qp::riccati_kernel<5, 2, 5>(), qp::riccati_kernel<0, 2, 5>(), qp::riccati_kernel<5, 0, 0>()};

}  // namespace

std::span<const qp::RiccatiKernel> sized_kernels() { return step_recovery_kernels; }

std::span<const qp::RiccatiKernel> chain_sizes() { return chain_kernels; }

std::span<const qp::RiccatiKernel> car_sizes() { return car_kernels; }

}  // namespace saltus::bench
