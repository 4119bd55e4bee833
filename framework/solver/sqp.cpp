#include "saltus/solver/sqp.hpp"

#include <utility>

#include "saltus/solver/sqp_run.hpp"

namespace saltus {
namespace {

class SqpSolver final : public Solver {
 public:
  SqpSolver(const Sqp& options, QpSolverFactory qp, QpSolverFactory relaxed_qp)
      : options_(options), make_qp_(std::move(qp)), make_relaxed_qp_(std::move(relaxed_qp)) {}

  std::string name() const override { return engine_ ? "SQP with " + engine_->qp->name() : "SQP"; }

  void set_deadline(WallClock::time_point deadline) override { deadline_ = deadline; }

  NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm) override {
    Curvature curvature = options_.curvature;
    if (!program.supports(curvature))
      curvature = curvature == Curvature::exact ? Curvature::gauss_newton : Curvature::exact;
    if (!program.supports(curvature) || !is_well_posed(program, start)) return refuse(program);
    if (engine_ == nullptr || !engine_->fits(program))
      engine_ = std::make_unique<SqpEngine>(program, options_, make_qp_);
    return SqpRun(program, options_, curvature, *engine_, make_relaxed_qp_, deadline_)
        .solve(start, warm);
  }

 private:
  static bool is_well_posed(const NonlinearProgram& program, const NlpPoint& start) {
    return start.w.size() == program.variables() && start.w.allFinite() &&
           (program.lower().array() <= program.upper().array()).all() &&
           (program.row_lower().array() <= program.row_upper().array()).all();
  }
  static NlpResult refuse(const NonlinearProgram& program) {
    NlpResult result;
    result.point = {VectorXd::Zero(program.variables()), VectorXd::Zero(program.rows()),
                    VectorXd::Zero(program.variables())};
    return result;
  }

  Sqp options_;
  QpSolverFactory make_qp_, make_relaxed_qp_;
  std::unique_ptr<SqpEngine> engine_;
  WallClock::time_point deadline_ = WallClock::time_point::max();
};

}  // namespace

std::unique_ptr<Solver> make_solver(const Sqp& options, QpSolverFactory qp,
                                    QpSolverFactory relaxed_qp) {
  return std::make_unique<SqpSolver>(options, std::move(qp), std::move(relaxed_qp));
}

}  // namespace saltus
