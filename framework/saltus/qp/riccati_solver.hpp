// The structured real-time solver: an interior-point method whose steps are Riccati sweeps.
#pragma once

#include <memory>
#include <span>

#include "saltus/qp/stage_qp_solver.hpp"

namespace saltus {

namespace qp {
struct RiccatiKernel;
}

/// How a quadratic program in stages is solved.
struct RiccatiOptions : QpOptions {
  /// Cold starts replace the states of the given point by those that its inputs lead to.
  bool roll_out = false;
  /// Warm starts first try to end with the sides in force that the multipliers name, in at most so
  /// many factorisations, each counted as an iteration; 0: they do not. That works beside the
  /// optimum; elsewhere the interior-point method begins where the first of them has come to.
  int active_set_rounds = 6;
};

/// `capacity`: a program of the largest sizes that will be solved. `kernels` of fixed sizes (see
/// riccati_kernels.hpp: riccati_kernel<nx, nu, next nx>()) are used for the stages that they fit;
/// a fixed start has nx = 0 in its stage, inputs with a common resultant count once.
std::unique_ptr<StageQpSolver> make_riccati_solver(const StageQp& capacity,
                                                   const RiccatiOptions& options = {},
                                                   std::span<const qp::RiccatiKernel> kernels = {});

}  // namespace saltus
