// The quadratic model of a shooting program in stages. Blocks write their derivatives directly into
// the stage matrices, and a measurement goes directly to the start of the first stage. Only the
// Hessian stays sparse, because convexification works on it and it changes least.
#pragma once

#include <memory>
#include <string>

#include "saltus/qp/stage_map.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/solver/quadratic_model.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// Solves one model, which it fills itself without sparse row entries. `program` and `model` must
/// outlive it. Does not allocate after construction.
class StageProgram final : public qp::QpSolver, private qp::DirectRows {
 public:
  StageProgram(ShootingProgram& program, QuadraticModel& model, const qp::MakeStageSolver& make);

  /// Builds the model at w, see QuadraticModel. Returns false if the program cannot be evaluated.
  bool linearise(const VectorXd& w, const VectorXd& lambda, Curvature curvature);
  /// Fills everything that is already known. solve() fills data that changes later.
  void fill() noexcept;

  /// `qp` belongs to the model.
  qp::QpResult solve(const qp::SparseQp& qp, PrimalDualPoint& point, bool warm) noexcept override;
  void set_deadline(WallClock::time_point deadline) override { solver_->set_deadline(deadline); }
  std::string name() const override { return "stages"; }

  const qp::StageQp& stages() const { return map_.stages(); }

 private:
  bool write(std::span<const detail::EntryTarget> targets) noexcept override;
  void multiply(const VectorXd& w, VectorXd& rows) const noexcept override;
  void add_transposed(const VectorXd& lambda, VectorXd& gradient) const noexcept override;

  ShootingProgram* program_;
  QuadraticModel* model_;
  qp::StageMap map_;
  qp::StagePoint point_;
  std::unique_ptr<qp::StageQpSolver> solver_;
  VectorXd at_, rows_times_w_;
  qp::StageFill state_ = qp::StageFill::not_staged;  // result of the last fill
  bool is_new_model_ = true;  // true if the model changed since the last fill
  long filled_bounds_ = -1;   // bounds_revision() at the last fill
};

}  // namespace saltus
