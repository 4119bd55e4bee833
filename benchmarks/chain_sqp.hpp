// A plain Gauss-Newton SQP for the hanging chain: linearise every stage, solve, take the full step.
#pragma once

#include <vector>

#include "benchmarks/hanging_chain.hpp"
#include "benchmarks/tracking_program.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::bench {

/// Q = 2 I with 4 for the position of the end, R = 0.02 I; |u| <= 1. The first state is that of
/// the data.
TrackingProgram chain_program(const ChainData& data);

/// One solve of the nonlinear program from the reference.
struct ChainSolve {
  struct Step {
    double linearisation = 0.0, qp = 0.0;  ///< microseconds
    qp::QpResult result;
    double qp_residual = 0.0;  ///< residual of the QP solution, recomputed
  };
  std::vector<Step> steps;
  double last_linearisation = 0.0;  ///< microseconds of the linearisation at the optimum
  double residual = 0.0;            ///< residual of the nonlinear program
};
ChainSolve solve_chain(TrackingProgram& program, qp::StageQpSolver& solver);

}  // namespace saltus::bench
