#include "saltus/integrators/implicit_stages.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <utility>

namespace saltus {
namespace {

// Newton's method converges quadratically with the current slopes: after a correction this small,
// only rounding remains. With older slopes it contracts linearly and stops at rounding level.
// Corrections are relative to nominal + |X| and to the state, which may be far below its nominal
// value. If a state loses digits to cancellation, iteration stops when corrections no longer
// decrease.
constexpr double converged_correction = 1e-9;
constexpr double rounding = 1e-15;
constexpr double noise = 1e-12, stalled = 0.5;
constexpr double slow_contraction = 0.02;  // then slopes are evaluated again
constexpr int max_corrections = 30;

// Continuation in the step length if Newton's method fails.
constexpr double shortest_fraction = 1e-9;
constexpr double longest_stride = 8.0, shortest_stride = 1.02;

bool is_strictly_lower(const MatrixXd& a) {
  for (int i = 0; i < a.rows(); ++i)
    for (int j = i; j < a.cols(); ++j)
      if (a(i, j) != 0.0) return false;
  return true;
}

}  // namespace

ImplicitStep::ImplicitStep(int count, const IntervalField& field, int entries)
    : stages(count, {VectorXd(field.arguments()), VectorXd(field.outputs()), VectorXd(entries),
                     VectorXd(field.outputs()), VectorXd(field.arguments())}),
      matrix(count * field.states()) {}

StageSolver::StageSolver(ButcherTableau tableau, const VectorXd& nominal_state, int states,
                         int outputs)
    : tableau_(std::move(tableau)),
      nx_(states),
      ny_(outputs),
      is_explicit_(is_strictly_lower(tableau_.a)),
      nominal_(nominal_state.size() > 0 ? nominal_state : VectorXd::Ones(states)),
      states_(count() * states),
      shorter_states_(count() * states),
      residual_(count() * states),
      slope_(outputs * outputs) {
  if (!is_explicit_) end_weights_ = tableau_.a.transpose().partialPivLu().solve(tableau_.b);
}

// Starts Newton's method at the start of the step. If the step is too long for that, continues from
// shorter steps.
IntegrationStatus StageSolver::find(const IntervalField& field, double s, double length,
                                    const double* x, ImplicitStep& step) {
  if (is_explicit_) return find_explicit(field, s, length, x, step);
  IntegrationStatus first = IntegrationStatus::success, status = first;
  for (fraction_ = 1.0; fraction_ > shortest_fraction; fraction_ /= longest_stride) {
    for (int i = 0; i < count(); ++i) std::copy_n(x, nx_, states_.data() + i * nx_);
    status = correct(field, s, length, x, step);
    if (status == IntegrationStatus::success) break;
    if (first == IntegrationStatus::success) first = status;
  }
  if (status == IntegrationStatus::success) {
    double stride = longest_stride;
    while (fraction_ < 1.0) {
      const double reached = fraction_;
      shorter_states_ = states_;
      fraction_ = std::min(1.0, stride * reached);
      if (correct(field, s, length, x, step) == IntegrationStatus::success) continue;
      states_ = shorter_states_;
      fraction_ = reached;
      stride = std::sqrt(stride);
      if (stride < shortest_stride) break;
    }
    if (fraction_ == 1.0) return IntegrationStatus::success;
  }
  fraction_ = 1.0;
  return first;
}

IntegrationStatus StageSolver::find_explicit(const IntervalField& field, double s, double length,
                                             const double* x, ImplicitStep& step) {
  for (int i = 0; i < count(); ++i) {
    double* state = states_.data() + i * nx_;
    std::copy_n(x, nx_, state);
    for (int j = 0; j < i; ++j) {
      const double a = length * field.length() * tableau_.a(i, j);
      for (int r = 0; r < nx_; ++r) state[r] += a * step.stages[j].phi[r];
    }
    ImplicitStep::Stage& stage = step.stages[i];
    field.argument(s + tableau_.c[i] * length, state, stage.z.data());
    field.value(stage.z.data(), stage.phi.data());
  }
  return states_.allFinite() ? IntegrationStatus::success : IntegrationStatus::not_finite;
}

IntegrationStatus StageSolver::correct(const IntervalField& field, double s, double step_length,
                                       const double* x, ImplicitStep& step) {
  bool fresh = true;
  double last = 0.0;
  for (int k = 0; k < max_corrections; ++k) {
    if (fresh) {
      const IntegrationStatus status = evaluate_slopes(field, s, step_length, step);
      if (status != IntegrationStatus::success) return status;
    } else {
      evaluate_rates(field, s, step_length, step);
    }
    const double length = fraction_ * step_length * field.length();
    for (int i = 0; i < count(); ++i)
      for (int r = 0; r < nx_; ++r) residual_[i * nx_ + r] = states_[i * nx_ + r] - x[r];
    for (int j = 0; j < count(); ++j) {
      const double* rates = step.stages[j].phi.data();
      for (int i = 0; i < count(); ++i) {
        const double a = length * tableau_.a(i, j);
        for (int r = 0; r < nx_; ++r) residual_[i * nx_ + r] -= a * rates[r];
      }
    }
    step.matrix.solve(residual_.data());
    double size = 0.0, own_size = 0.0;
    for (int i = 0; i < count(); ++i)
      for (int r = 0; r < nx_; ++r) {
        double& state = states_[i * nx_ + r];
        state -= residual_[i * nx_ + r];
        const double change = std::abs(residual_[i * nx_ + r]);
        if (change == 0.0) continue;
        size = std::max(size, change / (nominal_[r] + std::abs(state)));
        own_size = std::max(own_size, change / std::max(std::abs(state), std::abs(x[r])));
      }
    if (!residual_.allFinite()) return IntegrationStatus::not_finite;
    const double contraction = k == 0 ? 1.0 : size / last;
    const bool only_noise = k > 0 && contraction > stalled && size <= noise;
    const bool is_last = own_size <= converged_correction || only_noise;
    if (fresh ? size <= converged_correction && is_last
              : contraction < 1.0 && contraction * std::max(size, own_size) <= rounding)
      return IntegrationStatus::success;
    fresh = k > 0 && contraction > slow_contraction;
    last = size;
  }
  return IntegrationStatus::step_too_small;
}

void StageSolver::evaluate_rates(const IntervalField& field, double s, double length,
                                 ImplicitStep& step) {
  for (int i = 0; i < count(); ++i) {
    ImplicitStep::Stage& stage = step.stages[i];
    field.argument(s + tableau_.c[i] * length, state(i), stage.z.data());
    field.value(stage.z.data(), stage.phi.data());
  }
}

IntegrationStatus StageSolver::evaluate_slopes(const IntervalField& field, double s, double length,
                                               ImplicitStep& step) {
  for (int j = 0; j < count(); ++j) {
    ImplicitStep::Stage& stage = step.stages[j];
    field.argument(s + tableau_.c[j] * length, state(j), stage.z.data());
    field.jacobian(stage.z.data(), stage.phi.data(), stage.entries.data());
    field.scaled_state_jacobian(stage.entries.data(), slope_.data());
    for (int i = 0; i < count(); ++i) {
      const double a = fraction_ * length * tableau_.a(i, j);
      for (int r = 0; r < nx_; ++r) {
        double* row = step.matrix.row(i * nx_ + r) + j * nx_;
        for (int c = 0; c < nx_; ++c) row[c] = -a * slope_[c * ny_ + r];
        if (i == j) row[r] += 1.0;
      }
    }
  }
  if (step.matrix.factor()) return IntegrationStatus::success;
  return step.matrix.singular_row() < 0 ? IntegrationStatus::not_finite
                                        : IntegrationStatus::step_too_small;
}

}  // namespace saltus
