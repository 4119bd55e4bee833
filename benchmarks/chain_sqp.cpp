#include "benchmarks/chain_sqp.hpp"

#include <utility>

#include "benchmarks/measurement.hpp"
#include "saltus/core/clock.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus::bench {
namespace {

constexpr int nx = HangingChain::nx, nu = HangingChain::nu, intervals = HangingChain::intervals;
constexpr int most_steps = 30;

}  // namespace

TrackingProgram chain_program(const ChainData& data) {
  Tracking tracking{.nx = nx,
                    .nu = nu,
                    .intervals = intervals,
                    .substeps = HangingChain::substeps,
                    .sample = HangingChain::sample,
                    .dynamics = make_function<nx, nu, 0>(HangingChain{})};
  tracking.state_weight = VectorXd::Constant(nx, 2.0);
  tracking.state_weight.segment<3>(HangingChain::end)
      .setConstant(2.0 * (HangingChain::between + 1));
  tracking.input_weight = VectorXd::Constant(nu, 2e-2);
  tracking.input_upper = VectorXd::Constant(nu, HangingChain::fastest);
  tracking.input_lower = -tracking.input_upper;
  TrackingProgram program(std::move(tracking));
  program.start_at(data.start);
  for (int k = 0; k <= intervals; ++k) program.follow(k, data.reference);
  return program;
}

ChainSolve solve_chain(TrackingProgram& program, qp::StageQpSolver& solver) {
  ChainSolve solve;
  qp::StagePoint point = program.reference_point();
  while (true) {
    const double begin = thread_microseconds();
    program.linearise(point);
    const double linearised = thread_microseconds();
    // Before the first step there are no multipliers to check.
    if (!solve.steps.empty()) {
      solve.residual = kkt_residual(program.qp(), point).largest();
      if (solve.residual <= accepted_residual || solve.steps.size() == most_steps) {
        solve.last_linearisation = linearised - begin;
        return solve;
      }
    }
    ChainSolve::Step step;
    step.linearisation = linearised - begin;
    const double start = thread_microseconds();
    step.result = solver.solve(program.qp(), point, /*warm=*/false);
    step.qp = thread_microseconds() - start;
    step.qp_residual = kkt_residual(program.qp(), point).largest();
    solve.steps.push_back(step);
  }
}

}  // namespace saltus::bench
