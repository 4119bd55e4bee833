#include "saltus/mpc/real_time_iteration.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "saltus/solver/convexify.hpp"
#include "saltus/solver/differenced_program.hpp"
#include "saltus/solver/quadratic_model.hpp"
#include "saltus/transcription/stage_program.hpp"

namespace saltus {
namespace {

class Iteration final : public RealTimeSolver {
 public:
  Iteration(NonlinearProgram& program, RealTimeIterationOptions options)
      : options_(std::move(options)),
        is_exact_(program.is_linear_quadratic()),
        curvature_(choose_curvature(program, options_.curvature)),
        differenced_(curvature_ ? nullptr : std::make_unique<DifferencedProgram>(program)),
        model_(differentiable(program)),
        at_(VectorXd::Zero(program.variables())),
        lambda_(VectorXd::Zero(program.rows())) {
    if (!is_exact_)
      convexification_ = std::make_unique<Convexification>(model_.qp().hessian_pattern);
    start_ = {at_, lambda_, at_};
    make_qp_solver(differentiable(program));
  }

  void prepare(NonlinearProgram& program, const NlpPoint& guess) noexcept override {
    if (!is_exact_) {  // the model of a linear-quadratic program does not depend on w
      at_ = guess.w;
      if (guess.lambda.size() == lambda_.size())
        lambda_ = guess.lambda;
      else
        lambda_.setZero();
      revision_ = -1;
    }
    linearise(program);
    if (stages_ != nullptr && is_valid_) stages_->fill();
  }

  RealTimeSolver::Result feedback(NonlinearProgram& program, NlpPoint& point, bool warm,
                                  WallClock::time_point deadline) noexcept override {
    RealTimeSolver::Result result;
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
    if (cost_factor_ != 1.0) scale_multipliers(point, cost_factor_);
    start_ = point;
    qp_->set_deadline(deadline);
    qp::QpResult r = qp_->solve(model_.qp(), point, warm);
    result.iterations = r.iterations;
    const bool broke =
        r.status == qp::QpStatus::numerical_failure || r.status == qp::QpStatus::iteration_limit;
    // a warm start may be worse than a cold one
    if (warm && broke && WallClock::now() < deadline) {
      point = start_;
      r = qp_->solve(model_.qp(), point, false);
      result.iterations += r.iterations;
    }
    result.status = to_solve_status(r.status);
    // The optimum of the model is an optimum of the program only if the program is its own model
    // and the residual is small in the units of the program. Solvers of quadratic programs compare
    // the residual with the multipliers, which may be as large as a penalty weight. In all other
    // cases the caller checks the plan.
    constexpr double much_larger = 100.0;
    result.of_model = !is_exact_ || !(r.residual <= much_larger * options_.tolerance);
    if (result.of_model && result.status == SolveStatus::optimal)
      result.status = SolveStatus::step_taken;
    if (cost_factor_ != 1.0) scale_multipliers(point, 1.0 / cost_factor_);
    result.objective = r.objective / cost_factor_;
    result.kkt = std::max(r.residual / cost_factor_, r.violation);
    result.violation = r.violation;
    return result;
  }

  std::string name() const override {
    const std::string name = "real-time iteration with " + qp_->name();
    if (is_exact_) return name;
    return name + (!curvature_                      ? ", differenced Hessian"
                   : curvature_ == Curvature::exact ? ", exact Hessian"
                                                    : ", Gauss-Newton Hessian");
  }

 private:
  static std::optional<Curvature> choose_curvature(const NonlinearProgram& program,
                                                   Curvature asked) {
    if (!program.is_linear_quadratic() && !program.has_curved_cost()) asked = Curvature::exact;
    return supported_curvature(program, asked);
  }

  // The program with the second derivatives of the models.
  NonlinearProgram& differentiable(NonlinearProgram& program) const {
    return differenced_ != nullptr ? *differenced_ : program;
  }

  // A shooting program fills the stages directly; other programs are sorted into stages.
  void make_qp_solver(NonlinearProgram& program) {
    const qp::QpOptions asked{.tolerance = options_.tolerance,
                              .max_iterations = options_.max_iterations};
    auto* shooting = options_.qp ? nullptr : dynamic_cast<ShootingProgram*>(&program);
    if (shooting == nullptr) {
      const QpMethod method = options_.qp ? options_.qp : riccati_qp();
      qp_ = method(program, model_.qp().hessian_pattern, model_.qp().row_pattern, asked);
      return;
    }
    qp::RiccatiOptions riccati;
    riccati.tolerance = asked.tolerance;
    riccati.max_iterations = asked.max_iterations;
    auto stages =
        std::make_unique<StageProgram>(*shooting, model_, [&](const qp::StageQp& capacity) {
          return qp::make_riccati_solver(capacity, riccati, options_.kernels);
        });
    stages_ = stages.get();
    qp_ = std::move(stages);
  }

  // A formula that throws counts as a point that cannot be evaluated.
  void linearise(NonlinearProgram& program) noexcept {
    try {
      make_model(program);
    } catch (...) {
      is_valid_ = false;
      revision_ = -1;
    }
  }

  void make_model(NonlinearProgram& program) {
    if (revision_ >= 0 && revision_ == program.revision()) {
      if (stages_ == nullptr) model_.update_bounds(program);  // stages update their own bounds
      return;
    }
    const Curvature curvature = curvature_.value_or(Curvature::exact);
    is_valid_ = stages_ != nullptr
                    ? stages_->linearise(at_, lambda_, curvature)
                    : model_.linearise(differentiable(program), at_, lambda_, curvature);
    if (is_valid_ && convexification_ != nullptr) {
      convexification_->apply(model_.qp().hessian, options_.convexity_floor);
      model_.hessian_changed();
    }
    if (is_valid_) scale_tiny_cost();
    revision_ = is_valid_ ? program.revision() : -1;
  }

  // Solvers of quadratic programs have absolute tolerances, which any point meets if the cost is
  // tiny. The model of such a cost is multiplied by a power of two.
  void scale_tiny_cost() {
    constexpr double tiny = 1e-3;
    qp::SparseQp& qp = model_.qp();
    const double largest =
        std::max(qp.hessian.lpNorm<Eigen::Infinity>(), qp.gradient.lpNorm<Eigen::Infinity>());
    cost_factor_ =
        largest > 0.0 && largest < tiny ? std::exp2(-std::floor(std::log2(largest))) : 1.0;
    if (cost_factor_ == 1.0) return;
    qp.hessian *= cost_factor_;
    qp.gradient *= cost_factor_;
    qp.constant *= cost_factor_;
  }

  static void scale_multipliers(NlpPoint& point, double factor) {
    point.lambda *= factor;
    point.z *= factor;
  }

  RealTimeIterationOptions options_;
  bool is_exact_;
  std::optional<Curvature> curvature_;               // empty: finite differences
  std::unique_ptr<DifferencedProgram> differenced_;  // set if the program has no curvature
  QuadraticModel model_;
  std::unique_ptr<qp::QpSolver> qp_;
  StageProgram* stages_ = nullptr;  // qp_, if the program is written directly into stages
  std::unique_ptr<Convexification> convexification_;
  VectorXd at_, lambda_;  // point and multipliers of the model
  NlpPoint start_;
  double cost_factor_ = 1.0;  // of the model
  long revision_ = -1;        // revision of the program at the model
  bool is_valid_ = false;
};

}  // namespace

std::unique_ptr<RealTimeSolver> make_real_time_iteration(NonlinearProgram& program,
                                                         RealTimeIterationOptions options) {
  return std::make_unique<Iteration>(program, std::move(options));
}

}  // namespace saltus
