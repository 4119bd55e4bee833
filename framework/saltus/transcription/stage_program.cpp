#include "saltus/transcription/stage_program.hpp"

#include <limits>

#include "saltus/transcription/shooting_stages.hpp"

namespace saltus {

StageProgram::StageProgram(ShootingProgram& program, QuadraticModel& model,
                           const qp::MakeStageSolver& make)
    : program_(&program),
      model_(&model),
      map_(model.qp(), stage_structure(program)),
      point_(map_.stages()),
      solver_(make(map_.stages())),
      at_(VectorXd::Zero(program.variables())),
      rows_times_w_(VectorXd::Zero(program.rows())) {
  map_.write_directly(model.qp(), *this);
}

bool StageProgram::linearise(const VectorXd& w, const VectorXd& lambda, Curvature curvature) {
  at_ = w;
  is_new_model_ = true;
  rows_times_w_.setZero();
  program_->prepare_derivatives(w.data(), 1.0, lambda.data(), curvature);
  if (!w.isZero(0.0)) {
    if (!program_->evaluate_derivatives(w.data())) return false;
    program_->multiply_jacobian(w, rows_times_w_);
  }
  return model_->linearise(*program_, w, lambda, curvature, rows_times_w_);
}

void StageProgram::fill() noexcept {
  const bool same_bounds = filled_bounds_ == program_->bounds_revision();
  if (!is_new_model_ && same_bounds && map_.stages().fixed_start) {
    map_.restart(program_->row_lower());
    return;
  }
  if (!same_bounds) model_->update_bounds(*program_);
  state_ = map_.fill(model_->qp(), is_new_model_);
  is_new_model_ = state_ != qp::StageFill::filled;  // entries are missing unless the fill succeeded
  filled_bounds_ = program_->bounds_revision();
  if (state_ == qp::StageFill::filled) solver_->prepare(map_.stages());
}

qp::QpResult StageProgram::solve(const qp::SparseQp& qp, PrimalDualPoint& point,
                                 bool warm) noexcept {
  qp::QpResult result;
  if (point.w.size() != qp.variables()) return result;
  fill();
  if (state_ != qp::StageFill::filled) {
    result.status = state_ == qp::StageFill::infeasible ? qp::QpStatus::infeasible
                                                        : qp::QpStatus::invalid_problem;
    return result;
  }
  map_.convert(qp, point, point_);
  result = solver_->solve_prepared(map_.stages(), point_, warm);
  if (result.status != qp::QpStatus::invalid_problem) map_.convert(qp, point_, point);
  return result;
}

// If a formula throws, the point counts as not evaluable.

bool StageProgram::write(std::span<const detail::EntryTarget> targets) noexcept try {
  return program_->write_jacobian(at_.data(), targets);
} catch (...) {
  return false;
}

void StageProgram::multiply(const VectorXd& w, VectorXd& rows) const noexcept try {
  program_->evaluate_derivatives(at_.data());  // again if it was evaluated elsewhere
  program_->multiply_jacobian(w, rows);
} catch (...) {
  rows.setConstant(std::numeric_limits<double>::quiet_NaN());
}

void StageProgram::add_transposed(const VectorXd& lambda, VectorXd& gradient) const noexcept try {
  program_->evaluate_derivatives(at_.data());
  program_->add_jacobian_transposed(lambda, gradient);
} catch (...) {
  gradient.setConstant(std::numeric_limits<double>::quiet_NaN());
}

}  // namespace saltus
