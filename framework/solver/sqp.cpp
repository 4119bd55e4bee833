#include "saltus/solver/sqp.hpp"

#include <utility>

#include "saltus/solver/sqp_run.hpp"

namespace saltus {
namespace {

class SqpSolver final : public Solver {
 public:
  explicit SqpSolver(SqpOptions options) : options_(std::move(options)) {}

  std::string name() const override { return engine_ ? "SQP with " + engine_->qp->name() : "SQP"; }

  void set_deadline(WallClock::time_point deadline) override { deadline_ = deadline; }

  NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm) override {
    Curvature curvature = options_.curvature;
    if (!program.supports(curvature))
      curvature = curvature == Curvature::exact ? Curvature::gauss_newton : Curvature::exact;
    if (!program.supports(curvature) || !is_well_posed(program, start)) return refuse(program);
    if (engine_ == nullptr || !engine_->fits(program))
      engine_ = std::make_unique<SqpEngine>(program, options_);
    return SqpRun(program, options_, curvature, *engine_, deadline_).solve(start, warm);
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

  SqpOptions options_;
  std::unique_ptr<SqpEngine> engine_;
  WallClock::time_point deadline_ = WallClock::time_point::max();
};

}  // namespace

std::unique_ptr<Solver> make_sqp(SqpOptions options) {
  return std::make_unique<SqpSolver>(std::move(options));
}

}  // namespace saltus
