#include "benchmarks/tracking_program.hpp"

#include <stdexcept>
#include <utility>
#include <vector>

#include "saltus/integrators/runge_kutta.hpp"

namespace saltus::bench {

TrackingProgram::TrackingProgram(Tracking tracking) : tracking_(std::move(tracking)) {
  const Tracking& t = tracking_;
  std::vector<qp::StageCapacity> capacity(t.intervals + 1, {t.nx, t.nu, {}});
  capacity.back().nu = 0;
  qp_ = qp::StageQp(capacity);
  for (int k = 0; k <= t.intervals; ++k) {
    qp::Stage& s = qp_.stages[k];
    s.Q = t.state_weight.asDiagonal();
    if (k > 0 && t.state_lower.size() > 0) {
      s.x_lower = t.state_lower;
      s.x_upper = t.state_upper;
    }
    if (k == t.intervals) continue;
    s.R = t.input_weight.asDiagonal();
    s.u_lower = t.input_lower;
    s.u_upper = t.input_upper;
  }
  IntervalProblem interval;
  interval.arguments = {t.nx, t.nu, 0};
  interval.dynamics = t.dynamics;
  integrator_ = runge_kutta4({.steps = t.substeps})->make(interval);
  argument_ = VectorXd::Zero(integrator_->arguments().size());
  argument_[integrator_->arguments().h()] = t.sample;
  end_ = VectorXd::Zero(t.nx);
  derivative_ = MatrixXd::Zero(t.nx, argument_.size());
}

void TrackingProgram::follow(int stage, const VectorXd& reference) {
  qp::Stage& s = qp_.stages[stage];
  s.q = -tracking_.state_weight.cwiseProduct(reference);
  s.constant = -0.5 * reference.dot(s.q);
}

qp::StagePoint TrackingProgram::reference_point() const {
  qp::StagePoint point(qp_);
  for (std::size_t k = 0; k < point.stages.size(); ++k)
    point.stages[k].x = -qp_.stages[k].q.cwiseQuotient(tracking_.state_weight);
  return point;
}

void TrackingProgram::integrate(const VectorXd& state, const VectorXd& input) {
  argument_.head(tracking_.nx) = state;
  argument_.segment(tracking_.nx, tracking_.nu) = input;
  if (integrator_->jacobian(argument_.data(), end_.data(), derivative_) !=
      IntegrationStatus::success)
    throw std::runtime_error("the model could not be integrated");
}

void TrackingProgram::linearise(const qp::StagePoint& about) {
  const int nx = tracking_.nx, nu = tracking_.nu;
  for (int k = 0; k < tracking_.intervals; ++k) {
    const qp::StagePoint::AtStage& p = about.stages[k];
    qp::Stage& s = qp_.stages[k];
    integrate(p.x, p.u);
    s.A = derivative_.leftCols(nx);
    s.B = derivative_.middleCols(nx, nu);
    s.b = end_;
    s.b.noalias() -= s.A * p.x;
    s.b.noalias() -= s.B * p.u;
  }
}

VectorXd TrackingProgram::next(const VectorXd& state, const VectorXd& input) {
  integrate(state, input);
  return end_;
}

}  // namespace saltus::bench
