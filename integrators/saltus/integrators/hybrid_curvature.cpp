// Consider a step from s over the length L, both varying, with e_i = s + c_i L and multipliers
// lambda of its end:
//   sum_i M_ij' xi_i = L b_j F_Xj' lambda,     Fhat_j = b_j lambda + sum_i a_ij xi_i,
//   lambda- = lambda + sum_j xi_j,             Fbar_j = L Fhat_j,
//   d/ds = sum_j (Fbar_j' F_s,j (1 - c_j) - Fhat_j' F_j)   at a fixed end,
//   d2 += sum_j (Fbar_j' d2F_j + 2 dL Fhat_j' dF_j),
// where z varies with s, too: d2z = 2 de dz_s. For an event with reset R and guard g:
//   mu = -(d/ds + lambda+' (R_s + R_x B)) / (g_s + g_x B),   lambda- = R_x' lambda+ + mu g_x,
//   d2 += lambda+' d2R + mu d2g.
#include "saltus/integrators/hybrid_curvature.hpp"

#include <algorithm>
#include <utility>

#include "saltus/integrators/hybrid_stepper.hpp"

namespace saltus {
namespace {

// sum += a b' + b a'
void add_products(const VectorXd& a, const VectorXd& b, RowMajorMatrix& sum) {
  sum.noalias() += a * b.transpose();
  sum.noalias() += b * a.transpose();
}

}  // namespace

HybridCurvature::Step::Step(int stages, const IntervalField& any_field, int entries)
    : begin_moves(any_field.directions()),
      length_moves(any_field.directions()),
      at(stages, any_field, entries),
      dz(stages, RowMajorMatrix(any_field.arguments(), any_field.directions())),
      rates(stages, RowMajorMatrix(any_field.outputs(), any_field.directions())) {}

HybridCurvature::HybridCurvature(const IntervalProblem& problem, const HybridModes& modes,
                                 OneStepScheme scheme)
    : modes_(modes),
      steps_(scheme.steps),
      nx_(modes[0].field->states()),
      ny_(modes[0].field->outputs()),
      nd_(modes[0].field->directions()),
      entries_(modes.largest_entry_count()),
      solver_(std::move(scheme.tableau), problem.nominal_state, nx_, ny_),
      y_(ny_),
      lambda_(ny_),
      multipliers_(solver_.count() * nx_),
      explicit_(ny_),
      along_(nd_),
      gradient_(modes[0].field->arguments()),
      moves_(nd_),
      scaled_(ny_),
      z_(modes[0].field->arguments()),
      jacobian_(entries_),
      value_(ny_),
      total_(ny_, nd_),
      right_(solver_.count() * nx_, nd_),
      direct_(RowMajorMatrix::Zero(nx_, nd_)),
      dz_(modes[0].field->arguments(), nd_) {
  int most = 0;
  for (int m = 0; m < modes.count(); ++m)
    for (const OutgoingGuard& guard : modes[m].guards) {
      most = std::max(most, guard.function.hessian_pattern().entries());
      if (guard.reset) most = std::max(most, guard.reset.hessian_pattern().entries());
    }
  hessian_.resize(most);
}

IntegrationStatus HybridCurvature::hessian(const HybridTape& tape, const VectorXd& weights,
                                           Curvature curvature, RowMajorMatrix& sum) {
  used_ = 0;
  first_step_.clear();
  for (int i = 0; i < tape.count(); ++i) {
    first_step_.push_back(used_);
    if (tape[i].guard >= 0) continue;
    const IntegrationStatus status = find_steps(tape[i]);
    if (status != IntegrationStatus::success) return status;
  }
  sum.setZero();
  lambda_ = weights;
  for (int i = tape.count() - 1, last = used_; i >= 0; --i) {
    if (tape[i].guard >= 0) {
      add_event(tape[i], curvature, sum);
    } else {
      for (int k = last - 1; k >= first_step_[i]; --k) sweep_back(pool_[k], curvature, sum);
    }
    last = first_step_[i];
  }
  return all_finite(sum.data(), static_cast<int>(sum.size())) ? IntegrationStatus::success
                                                              : IntegrationStatus::not_finite;
}

// Reconstructs the steps of a flow, as its stepper took them, with first derivatives.
IntegrationStatus HybridCurvature::find_steps(const HybridPiece& flow) {
  y_ = flow.state;
  total_ = flow.total;
  double s = flow.begin;
  do {
    if (used_ == static_cast<int>(pool_.size()))
      pool_.emplace_back(solver_.count(), *modes_[0].field, entries_);
    Step& step = pool_[used_++];
    step.field = modes_[flow.mode].field.get();
    step.begin = s;
    const double end = std::min(flow.end, next_grid_point(s, steps_));
    step.length = std::max(0.0, end - s);
    step.begin_moves.setZero();
    step.length_moves.setZero();
    if (s == flow.begin) step.begin_moves = flow.begin_moves;
    if (end >= flow.end) step.length_moves = flow.end_moves;
    step.length_moves -= step.begin_moves;
    const IntegrationStatus status = differentiate(step);
    if (status != IntegrationStatus::success) return status;
    s = end;
  } while (s < flow.end);
  return IntegrationStatus::success;
}

// Computes the stages of a step from y_ and total_, and updates both to its end.
IntegrationStatus HybridCurvature::differentiate(Step& step) {
  const IntervalField& field = *step.field;
  const ButcherTableau& tableau = solver_.tableau();
  IntegrationStatus status = solver_.find(field, step.begin, step.length, y_.data(), step.at);
  if (status == IntegrationStatus::success)
    status = solver_.evaluate_slopes(field, step.begin, step.length, step.at);
  if (status != IntegrationStatus::success) return status;

  const auto differentiate_stage = [&](int j, const RowMajorMatrix& sensitivity) {
    const ImplicitStep::Stage& stage = step.at.stages[j];
    moves_ = step.begin_moves + tableau.c[j] * step.length_moves;
    field.differentiate_argument(step.begin + tableau.c[j] * step.length, sensitivity,
                                 moves_.data(), step.dz[j]);
    field.rate_differential(stage.phi.data(), stage.entries.data(), step.dz[j], step.rates[j]);
  };
  direct_.setZero();
  for (int j = 0; j < solver_.count(); ++j) differentiate_stage(j, direct_);
  for (int i = 0; i < solver_.count(); ++i)
    for (int r = 0; r < nx_; ++r) {
      auto row = right_.row(i * nx_ + r);
      row = total_.row(r);
      for (int j = 0; j < solver_.count(); ++j)
        row += tableau.a(i, j) *
               (step.length * step.rates[j].row(r) +
                field.length() * step.at.stages[j].phi[r] * step.length_moves.transpose());
    }
  step.at.matrix.solve(right_.data(), nd_);
  for (int j = 0; j < solver_.count(); ++j) {
    direct_ = right_.middleRows(j * nx_, nx_);
    differentiate_stage(j, direct_);
    for (int r = 0; r < ny_; ++r) {
      const double rate = field.length() * step.at.stages[j].phi[r];
      y_[r] += tableau.b[j] * step.length * rate;
      total_.row(r) += tableau.b[j] *
                       (step.length * step.rates[j].row(r) + rate * step.length_moves.transpose());
    }
  }
  return IntegrationStatus::success;
}

void HybridCurvature::sweep_back(Step& step, Curvature curvature, RowMajorMatrix& sum) {
  const IntervalField& field = *step.field;
  const ButcherTableau& tableau = solver_.tableau();
  const double h = field.length(), length = step.length;
  for (int j = 0; j < solver_.count(); ++j) {
    ImplicitStep::Stage& stage = step.at.stages[j];
    stage.adjoint = length * tableau.b[j] * lambda_;
    field.adjoint(stage.entries.data(), stage.adjoint.data(), stage.gradient.data());
    for (int r = 0; r < nx_; ++r) multipliers_[j * nx_ + r] = h * stage.gradient[1 + r];
  }
  step.at.matrix.solve_transposed(multipliers_.data());
  start_multiplier_ = 0.0;
  for (int j = 0; j < solver_.count(); ++j) {
    ImplicitStep::Stage& stage = step.at.stages[j];
    scaled_ = tableau.b[j] * lambda_;  // Fhat
    for (int i = 0; i < solver_.count(); ++i)
      scaled_.head(nx_) += tableau.a(i, j) * multipliers_.segment(i * nx_, nx_);
    stage.adjoint = length * scaled_;
    field.explicit_rate(stage.entries.data(), explicit_.data());
    start_multiplier_ +=
        (1.0 - tableau.c[j]) * stage.adjoint.dot(explicit_) - h * scaled_.dot(stage.phi);
    field.add_moving_curvature(stage.z.data(), stage.adjoint.data(), step.dz[j], curvature, sum);
    if (curvature != Curvature::exact) continue;
    field.adjoint(stage.entries.data(), stage.adjoint.data(), stage.gradient.data());
    if (field.differentiates_time()) {
      along_.noalias() = step.dz[j].transpose() * stage.gradient;
      sum.row(field.h_direction()) += along_.transpose();
      sum.col(field.h_direction()) += along_;
    }
    along_.noalias() = step.rates[j].transpose() * scaled_;
    add_products(step.length_moves, along_, sum);
    moves_ = h * (step.begin_moves + tableau.c[j] * step.length_moves);
    field.slope_differential(stage.gradient.data(), along_.data());
    add_products(moves_, along_, sum);
  }
  for (int j = 0; j < solver_.count(); ++j) lambda_.head(nx_) += multipliers_.segment(j * nx_, nx_);
}

void HybridCurvature::add_event(const HybridPiece& event, Curvature curvature,
                                RowMajorMatrix& sum) {
  const IntervalField& field = *modes_[event.mode].field;
  const OutgoingGuard& guard = modes_[event.mode].guards[event.guard];
  field.argument(event.begin, event.state.data(), z_.data());
  field.differentiate_argument(event.begin, event.total, event.begin_moves.data(), dz_);
  double instant = start_multiplier_;
  if (guard.reset) {
    const SparsityPattern& pattern = guard.reset.jacobian_pattern();
    guard.reset.jacobian(z_.data(), value_.data(), jacobian_.data());
    field.explicit_slope(pattern, jacobian_.data(), explicit_.data());
    instant += lambda_.head(nx_).dot(explicit_.head(nx_));
    if (curvature == Curvature::exact) add_second(guard.reset, lambda_.data(), event, sum);
    gradient_.setZero();
    pattern.for_each([&](int r, int c, int e) { gradient_[c] += lambda_[r] * jacobian_[e]; });
    lambda_.head(nx_) = gradient_.segment(1, nx_);
  }
  if (!event.located) return;
  instant += lambda_.dot(event.slope);
  const double multiplier = -instant / event.rate;
  if (curvature == Curvature::exact) add_second(guard.function, &multiplier, event, sum);
  guard.function.jacobian(z_.data(), value_.data(), jacobian_.data());
  guard.function.jacobian_pattern().for_each([&](int, int c, int e) {
    if (c >= 1 && c <= nx_) lambda_[c - 1] += multiplier * jacobian_[e];
  });
}

// Adds weight' d2 of a function of z at an event.
void HybridCurvature::add_second(const Function& function, const double* weight,
                                 const HybridPiece& event, RowMajorMatrix& sum) {
  function.hessian(z_.data(), weight, hessian_.data(), Curvature::exact);
  function.hessian_pattern().for_each([&](int a, int b, int e) {
    sum.noalias() += hessian_[e] * dz_.row(a).transpose() * dz_.row(b);
    if (a != b) sum.noalias() += hessian_[e] * dz_.row(b).transpose() * dz_.row(a);
  });
  function.jacobian(z_.data(), value_.data(), jacobian_.data());
  gradient_.setZero();
  function.jacobian_pattern().for_each(
      [&](int r, int c, int e) { gradient_[c] += weight[r] * jacobian_[e]; });
  modes_[event.mode].field->slope_differential(gradient_.data(), along_.data());
  add_products(event.begin_moves, along_, sum);
}

}  // namespace saltus
