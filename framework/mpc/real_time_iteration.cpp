#include "saltus/mpc/real_time_iteration.hpp"

#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/solver/convexify.hpp"
#include "saltus/solver/quadratic_model.hpp"

namespace saltus {
namespace {

class Iteration final : public RealTimeSolver {
 public:
  Iteration(const NonlinearProgram& program, RealTimeIterationOptions options)
      : options_(std::move(options)),
        is_exact_(program.is_linear_quadratic()),
        curvature_(options_.curvature),
        model_(program),
        qp_(options_.qp(
            program, model_.qp().hessian_pattern, model_.qp().row_pattern,
            {.tolerance = options_.tolerance, .max_iterations = options_.max_iterations})),
        at_(VectorXd::Zero(program.variables())),
        lambda_(VectorXd::Zero(program.rows())) {
    if (!program.supports(curvature_))
      curvature_ = curvature_ == Curvature::exact ? Curvature::gauss_newton : Curvature::exact;
    if (!program.supports(curvature_))
      throw DefinitionError("the real-time iteration needs a Hessian, but the program has none");
    if (!is_exact_)
      convexification_ = std::make_unique<Convexification>(model_.qp().hessian_pattern);
    start_ = {at_, lambda_, at_};
  }

  void prepare(NonlinearProgram& program, const NlpPoint& guess) noexcept override {
    if (!is_exact_) {  // the model of a linear-quadratic program is the same everywhere
      at_ = guess.w;
      if (guess.lambda.size() == lambda_.size())
        lambda_ = guess.lambda;
      else
        lambda_.setZero();
      revision_ = -1;
    }
    linearise(program);
  }

  TickResult feedback(NonlinearProgram& program, NlpPoint& point, bool warm,
                      WallClock::time_point deadline) noexcept override {
    TickResult result;
    linearise(program);
    if (!is_valid_) {
      result.status = SolveStatus::evaluation_failed;
      return result;
    }
    warm = warm && point.lambda.size() == lambda_.size() && point.z.size() == at_.size();
    if (!warm) {
      point.lambda.setZero(lambda_.size());
      point.z.setZero(at_.size());
    }
    start_ = point;
    qp_->set_deadline(deadline);
    QpResult r = qp_->solve(model_.qp(), point, warm);
    result.iterations = r.iterations;
    const bool broke =
        r.status == QpStatus::numerical_failure || r.status == QpStatus::iteration_limit;
    if (warm && broke && WallClock::now() < deadline) {  // a warm start may be worse than none
      point = start_;
      r = qp_->solve(model_.qp(), point, false);
      result.iterations += r.iterations;
    }
    result.status = to_solve_status(r.status);
    // The optimum of a model is the program's only where the program is its own model.
    if (!is_exact_ && result.status == SolveStatus::optimal)
      result.status = SolveStatus::step_taken;
    result.objective = r.objective;
    result.kkt = r.residual;
    result.violation = r.violation;
    return result;
  }

  std::string name() const override { return "real-time iteration with " + qp_->name(); }

 private:
  void linearise(NonlinearProgram& program) {
    if (revision_ >= 0 && revision_ == program.revision()) {
      model_.update_bounds(program);
      return;
    }
    is_valid_ = model_.linearise(program, at_, lambda_, curvature_);
    if (is_valid_ && convexification_ != nullptr) {
      convexification_->apply(model_.qp().hessian, options_.convexity_floor);
      model_.hessian_changed();
    }
    revision_ = is_valid_ ? program.revision() : -1;
  }

  RealTimeIterationOptions options_;
  bool is_exact_;
  Curvature curvature_;
  QuadraticModel model_;
  std::unique_ptr<QpSolver> qp_;
  std::unique_ptr<Convexification> convexification_;
  VectorXd at_, lambda_;  // of the model
  NlpPoint start_;
  long revision_ = -1;  // of the program that the model is of
  bool is_valid_ = false;
};

}  // namespace

std::unique_ptr<RealTimeSolver> make_real_time_iteration(const NonlinearProgram& program,
                                                         RealTimeIterationOptions options) {
  return std::make_unique<Iteration>(program, std::move(options));
}

}  // namespace saltus
