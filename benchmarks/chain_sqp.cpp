#include "benchmarks/chain_sqp.hpp"

#include <stdexcept>

#include "benchmarks/measurement.hpp"
#include "saltus/core/clock.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus::bench {
namespace {

constexpr int nx = HangingChain::nx, nu = HangingChain::nu, intervals = HangingChain::intervals;
constexpr int most_steps = 30;

}  // namespace

ChainProgram::ChainProgram(const ChainData& data) : data_(data) {
  std::vector<StageCapacity> capacity(intervals + 1, {nx, nu, {}});
  capacity.back().nu = 0;
  qp_ = StageQp(capacity);
  qp_.start = data.start;
  Vec<double, nx> weight = Vec<double, nx>::Constant(2.0);
  weight.segment<3>(HangingChain::end).setConstant(2.0 * (HangingChain::between + 1));
  for (int k = 0; k <= intervals; ++k) {
    Stage& s = qp_.stages[k];
    s.Q = weight.asDiagonal();
    s.q = -weight.cwiseProduct(data.reference);
    s.constant = 0.5 * data.reference.dot(weight.cwiseProduct(data.reference));
    if (k == intervals) continue;
    s.R = 2e-2 * MatrixXd::Identity(nu, nu);
    s.u_lower.setConstant(-HangingChain::fastest);
    s.u_upper.setConstant(HangingChain::fastest);
  }
  IntervalProblem interval;
  interval.arguments = {nx, nu, 0};
  interval.dynamics = make_function<nx, nu, 0>(HangingChain{});
  integrator_ = runge_kutta4({.steps = HangingChain::substeps})->make(interval);
  argument_ = VectorXd::Zero(integrator_->arguments().size());
  argument_[integrator_->arguments().h()] = HangingChain::sample;
  end_ = VectorXd::Zero(nx);
  derivative_ = MatrixXd::Zero(nx, argument_.size());
}

StagePoint ChainProgram::reference_point() const {
  StagePoint point(qp_);
  for (StagePoint::AtStage& p : point.stages) p.x = data_.reference;
  return point;
}

void ChainProgram::linearise(const StagePoint& about) {
  for (int k = 0; k < intervals; ++k) {
    const StagePoint::AtStage& p = about.stages[k];
    Stage& s = qp_.stages[k];
    argument_.head<nx>() = p.x;
    argument_.segment<nu>(nx) = p.u;
    if (integrator_->jacobian(argument_.data(), end_.data(), derivative_) !=
        IntegrationStatus::success)
      throw std::runtime_error("the hanging chain could not be integrated");
    s.A = derivative_.leftCols<nx>();
    s.B = derivative_.middleCols<nu>(nx);
    s.b = end_;
    s.b.noalias() -= s.A * p.x;
    s.b.noalias() -= s.B * p.u;
  }
}

ChainSolve solve_chain(ChainProgram& program, StageQpSolver& solver) {
  ChainSolve solve;
  StagePoint point = program.reference_point();
  while (true) {
    const double begin = thread_microseconds();
    program.linearise(point);
    const double linearised = thread_microseconds();
    // Before the first step there are no multipliers and nothing to check.
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
