// The quadratic model of a shooting program in stages: blocks write their slopes straight into the
// matrices of the stages, and a measurement goes from its rows to the start of the first stage.
// What is left sparse is the Hessian, which is convexified as such and changes least.
#pragma once

#include <memory>
#include <string>

#include "saltus/qp/sparse_by_stages.hpp"
#include "saltus/qp/stage_map.hpp"
#include "saltus/solver/quadratic_model.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// Solves one model, which is filled here and has no entries of rows of its own. `program` and
/// `model` must outlive it. After construction nothing allocates.
class StageProgram final : public QpSolver, private DirectRows {
 public:
  StageProgram(ShootingProgram& program, QuadraticModel& model, const MakeStageSolver& make);

  /// The model at w, see QuadraticModel. False where the program cannot be evaluated.
  bool linearise(const VectorXd& w, const VectorXd& lambda, Curvature curvature);
  /// Everything that can be filled by now; what changes later is filled by solve().
  void fill() noexcept;

  /// `qp` is that of the model.
  QpResult solve(const SparseQp& qp, PrimalDualPoint& point, bool warm) noexcept override;
  void set_deadline(WallClock::time_point deadline) override { solver_->set_deadline(deadline); }
  std::string name() const override { return "stages"; }

  const StageQp& stages() const { return map_.stages(); }

 private:
  bool write(std::span<const EntryTarget> targets) noexcept override;
  void multiply(const VectorXd& w, VectorXd& rows) const noexcept override;
  void add_transposed(const VectorXd& lambda, VectorXd& gradient) const noexcept override;

  ShootingProgram* program_;
  QuadraticModel* model_;
  StageMap map_;
  StagePoint point_;
  std::unique_ptr<StageQpSolver> solver_;
  VectorXd at_, rows_times_w_;
  StageFill state_ = StageFill::not_staged;  // of the last fill
  bool is_new_model_ = true;                 // since then
  long filled_bounds_ = -1;                  // bounds_revision() of then
};

}  // namespace saltus
