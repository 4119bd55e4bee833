// The structured real-time solver: an interior-point method whose steps are Riccati sweeps.
#pragma once

#include <memory>
#include <span>

#include "saltus/qp/stage_qp_solver.hpp"

namespace saltus {

namespace qp {
struct RiccatiKernel;
}

/// Options of the solver for quadratic programs in stages.
struct RiccatiOptions : QpOptions {
  /// True: a cold start replaces the states of the given point by a roll-out of its inputs.
  bool roll_out = false;
  /// Maximum number of active-set factorisations of a warm start, each counted as an iteration; 0
  /// disables them. They start from the active set that the multipliers indicate and succeed close
  /// to the optimum. If they fail, the interior-point method starts from the result of the first
  /// one.
  int active_set_rounds = 6;
};

/// `capacity` is a program of the largest sizes to be solved. `kernels` of fixed sizes (see
/// riccati_kernels.hpp: riccati_kernel<nx, nu, next nx>()) are used for the stages that they fit. A
/// fixed start has nx = 0 in its stage. Inputs with a common resultant count once.
std::unique_ptr<StageQpSolver> make_riccati_solver(const StageQp& capacity,
                                                   const RiccatiOptions& options = {},
                                                   std::span<const qp::RiccatiKernel> kernels = {});

}  // namespace saltus
