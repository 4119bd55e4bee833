#include "framework/solver/sqp.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include "framework/solver/active_set.hpp"
#include "framework/solver/convexify.hpp"
#include "framework/solver/elastic_qp.hpp"
#include "framework/solver/quadratic_model.hpp"

namespace saltus {
namespace {

constexpr double armijo = 1e-4;            // of the promised decrease, customary
constexpr double shortest_step = 1e-7;     // a step this short means that the model is wrong
constexpr double rounding = 1e-13;         // of the merit function, relative
constexpr double first_shift = 1e-4;       // Levenberg, relative to the largest diagonal entry
constexpr int most_shifts = 8;             // each ten times the last
constexpr double elastic_price = 1e3;      // times the largest multiplier and gradient
constexpr double acceptable_factor = 1e3;  // on the tolerance, where progress has stopped
constexpr double stalled = 1e-9;           // relative change of w, or of its violation

double seconds_since(QpClock::time_point start) {
  return std::chrono::duration<double>(QpClock::now() - start).count();
}

double violation(double value, double lower, double upper) {
  return std::max({lower - value, value - upper, 0.0});
}

double largest(const VectorXd& v) { return v.size() == 0 ? 0.0 : v.cwiseAbs().maxCoeff(); }

// What depends on the patterns only, kept between solves.
struct Engine {
  Engine(const NonlinearProgram& program, const Sqp& options, const QpSolverFactory& make)
      : model(program), qp_options{.tolerance = 0.01 * options.tolerance, .convex = false} {
    if (program.is_linear_quadratic())
      qp_options = {.tolerance = options.tolerance, .max_iterations = options.max_iterations};
    else
      convexification = std::make_unique<Convexification>(model.qp().hessian_pattern);
    qp = make(model.qp().hessian_pattern, model.qp().row_pattern, qp_options);
    hessian_pattern = program.hessian_pattern();
  }
  bool fits(const NonlinearProgram& p) const {
    return hessian_pattern == p.hessian_pattern() &&
           model.qp().row_pattern == p.jacobian_pattern() &&
           p.is_linear_quadratic() == (convexification == nullptr);
  }

  QuadraticModel model;
  QpOptions qp_options;
  SparsityPattern hessian_pattern;  // of the program
  std::unique_ptr<QpSolver> qp;
  std::unique_ptr<Convexification> convexification;  // of nonlinear programs
  std::unique_ptr<ElasticQp> elastic;
};

// One solve.
class Run {
 public:
  Run(NonlinearProgram& program, const Sqp& options, Curvature curvature, Engine& engine,
      const QpSolverFactory& relaxed, QpClock::time_point deadline)
      : program_(program),
        options_(options),
        curvature_(curvature),
        engine_(engine),
        relaxed_(relaxed),
        model_(engine.model),
        price_(VectorXd::Zero(program.rows())),
        rows_(VectorXd::Zero(program.rows())),
        deadline_(deadline) {
    if (options.time_limit > 0.0)
      deadline_ =
          std::min(deadline_, begin_ + std::chrono::duration_cast<QpClock::duration>(
                                           std::chrono::duration<double>(options.time_limit)));
    engine_.qp->set_deadline(deadline_);
  }

  NlpResult solve(const NlpPoint& start, bool warm) {
    NlpResult result;
    point_.w = start.w.cwiseMax(program_.lower()).cwiseMin(program_.upper());
    warm = warm && start.lambda.size() == program_.rows();
    point_.lambda = warm ? start.lambda : VectorXd::Zero(program_.rows());
    point_.z =
        warm && start.z.size() == program_.variables() ? start.z : VectorXd::Zero(start.w.size());
    result.status = program_.is_linear_quadratic() ? solve_once(warm) : iterate(warm);
    result.iterations = iterations_;
    result.hessian = curvature_ == Curvature::exact ? "exact" : "Gauss-Newton";
    result.kkt = kkt_residual(program_, point_);
    if (!program_.objective(point_.w.data(), result.objective) && is_success(result.status))
      result.status = SolveStatus::evaluation_failed;
    result.point = std::move(point_);
    result.seconds = seconds_since(begin_);
    return result;
  }

 private:
  bool timed_out() const { return QpClock::now() >= deadline_; }

  SolveStatus solve_once(bool warm) {
    if (!model_.linearise(program_, VectorXd::Zero(program_.variables()), point_.lambda,
                          curvature_))
      return SolveStatus::evaluation_failed;
    const NlpPoint start = point_;
    QpResult r = engine_.qp->solve(model_.qp(), point_, warm);
    iterations_ = r.iterations;
    const bool broke =
        r.status == QpStatus::numerical_failure || r.status == QpStatus::iteration_limit;
    if (warm && broke) {  // a warm start may be worse than none
      point_ = start;
      r = engine_.qp->solve(model_.qp(), point_, false);
      iterations_ += r.iterations;
    }
    if (r.status == QpStatus::infeasible) {  // the least violation, for the report
      point_ = start;
      relax();
    }
    return to_solve_status(r.status);
  }

  SolveStatus iterate(bool warm) {
    for (;; ++iterations_) {
      if (!model_.linearise(program_, point_.w, point_.lambda, curvature_))
        return SolveStatus::evaluation_failed;
      kkt_ = kkt_residual(program_, point_);
      if (kkt_.scaled() <= options_.tolerance && (warm || iterations_ > 0))
        return SolveStatus::optimal;
      if (timed_out()) return SolveStatus::time_limit;
      if (iterations_ >= options_.max_iterations) return SolveStatus::iteration_limit;
      const SolveStatus status = step(warm || iterations_ > 0);
      if (status == SolveStatus::optimal) continue;  // it was taken
      if (status == SolveStatus::numerical_failure &&
          kkt_.scaled() <= acceptable_factor * options_.tolerance)
        return SolveStatus::acceptable;
      return status;
    }
  }

  // One step, `optimal` if it was taken. Models become more careful until one serves.
  SolveStatus step(bool warm) {
    exact_ = model_.qp().hessian;
    SolveStatus status = SolveStatus::numerical_failure;
    bool is_elastic = false;
    for (int care = 0; care < 3 + most_shifts; ++care) {
      if (care == 1) {
        missing_ = ActiveSet::equalities(model_.qp())
                       .missing_curvature(model_.qp(), options_.convexity_floor);
        if (missing_ == 0.0) continue;
      }
      set_care(care);
      next_ = point_;
      QpResult r;
      if (!is_elastic) {
        r = engine_.qp->solve(model_.qp(), next_, warm);
        // A warm start may be worse than none, or pass for the solution by the solver's own scale.
        const bool stays = next_.w == point_.w;
        if (warm && (!serves(r) || stays) && r.status != QpStatus::deadline) {
          next_ = point_;
          r = engine_.qp->solve(model_.qp(), next_, false);
        }
        is_elastic = r.status == QpStatus::infeasible;
      }
      if (is_elastic) {
        next_ = point_;
        r = solve_elastic(next_);
      }
      if (r.status == QpStatus::deadline) return SolveStatus::time_limit;
      if (r.status == QpStatus::invalid_problem) return SolveStatus::numerical_failure;
      if (r.status == QpStatus::unbounded) status = SolveStatus::unbounded;
      if (!serves(r)) continue;
      if (is_elastic && is_stuck()) {
        if (care >= 2) return SolveStatus::infeasible;  // also a convex model cannot reduce it
        continue;
      }
      if (care > 0 && !is_elastic && newton()) return SolveStatus::optimal;
      if (search(is_elastic, shortest_step)) return SolveStatus::optimal;
      status = SolveStatus::numerical_failure;
    }
    return status;
  }

  // On the surface of the rows that a careful model found active less care is needed. Its
  // stationary point is taken if it is closer to a KKT point, or if the merit function likes it.
  bool newton() {
    SparseQp& qp = model_.qp();
    const ActiveSet active = ActiveSet::at(qp, next_);
    std::swap(qp.hessian, exact_);
    model_.hessian_changed();
    const NlpPoint careful = next_;
    const bool found = active.solve(qp, options_.convexity_floor, next_);
    std::swap(qp.hessian, exact_);
    model_.hessian_changed();
    if (found) {
      next_.w = next_.w.cwiseMax(program_.lower()).cwiseMin(program_.upper());
      if (kkt_residual(program_, next_).scaled() <= 0.5 * kkt_.scaled()) {
        point_ = next_;
        return true;
      }
      if (search(false, 0.05)) return true;
    }
    next_ = careful;
    return false;
  }

  bool serves(const QpResult& r) const {
    return r.status == QpStatus::optimal || r.residual <= options_.tolerance;
  }

  // 0: as it is; 1: as convex as it needs to be; 2: convexified by blocks; above: shifted as well.
  void set_care(int care) {
    if (care == 0) return;
    VectorXd& hessian = model_.qp().hessian;
    hessian = exact_;
    if (care == 1 && std::isfinite(missing_))
      engine_.convexification->add_to_diagonal(hessian, missing_);
    else
      engine_.convexification->apply(hessian, options_.convexity_floor);
    if (care > 2)
      engine_.convexification->add_to_diagonal(
          hessian,
          first_shift * std::pow(10.0, care - 3) * std::max(1.0, hessian.cwiseAbs().maxCoeff()));
    model_.hessian_changed();
  }

  QpResult solve_elastic(NlpPoint& point) {
    if (engine_.elastic == nullptr)
      engine_.elastic = std::make_unique<ElasticQp>(model_.qp(), relaxed_, engine_.qp_options);
    elastic_price_ = elastic_price * std::max({1.0, largest(model_.gradient()),
                                               largest(point_.lambda) / elastic_price});
    return engine_.elastic->solve(model_.qp(), elastic_price_, point, deadline_);
  }
  void relax() {
    NlpPoint relaxed = point_;
    if (serves(solve_elastic(relaxed))) point_ = relaxed;
  }

  // Violations at the point that neither the relaxed model nor therefore the program can reduce.
  bool is_stuck() {
    const double before = violation_of(model_.constraints());
    return before > options_.tolerance &&
           (linear_violation() >= (1.0 - 1e-6) * before ||
            largest(next_.w - point_.w) <= stalled * (1.0 + largest(point_.w)));
  }

  double violation_of(const VectorXd& c) const {
    double sum = 0.0;
    for (int i = 0; i < c.size(); ++i)
      sum += violation(c[i], program_.row_lower()[i], program_.row_upper()[i]);
    return sum;
  }
  double linear_violation() {
    multiply(model_.qp().row_pattern, model_.qp().rows, next_.w - point_.w, rows_);
    rows_ += model_.constraints();
    return violation_of(rows_);
  }
  double priced(const VectorXd& c) const {
    double sum = 0.0;
    for (int i = 0; i < c.size(); ++i)
      sum += price_[i] * violation(c[i], program_.row_lower()[i], program_.row_upper()[i]);
    return sum;
  }
  bool merit(const VectorXd& w, double& phi) {
    double f = 0.0;
    if (!program_.objective(w.data(), f) || !program_.constraints(w.data(), rows_.data()))
      return false;
    phi = f + priced(rows_);
    return std::isfinite(phi);
  }

  // Takes as much of the step to next_ as the merit function likes, if that is more than
  // `shortest`.
  bool search(bool is_elastic, double shortest) {
    for (int i = 0; i < price_.size(); ++i) {
      const double l = std::abs(next_.lambda[i]);
      price_[i] = std::max(1.1 * l, 0.5 * (price_[i] + l));
      if (is_elastic) price_[i] = std::max(price_[i], elastic_price_);
    }
    const VectorXd d = next_.w - point_.w;
    multiply(model_.qp().row_pattern, model_.qp().rows, d, rows_);
    rows_ += model_.constraints();
    const double promised = model_.gradient().dot(d) + priced(rows_) - priced(model_.constraints());
    const double phi = model_.cost() + priced(model_.constraints());
    const double noise = rounding * (std::abs(model_.cost()) + std::abs(phi) + 1.0);
    if (promised > noise) return false;

    double trial_phi = 0.0;
    const auto falls = [&](const VectorXd& w, double alpha) {
      return merit(w, trial_phi) && trial_phi <= phi + armijo * alpha * promised + noise;
    };
    VectorXd w = next_.w;
    if (falls(w, 1.0)) return take(w, 1.0);
    if (shortest >= 1.0) return false;
    if (!is_elastic && program_.constraints(w.data(), rows_.data())) {
      NlpPoint corrected = next_;
      model_.correct_rows(program_, w, rows_);
      const QpResult r = engine_.qp->solve(model_.qp(), corrected, true);
      if (serves(r) && falls(corrected.w, 1.0)) {
        next_ = std::move(corrected);
        return take(next_.w, 1.0);
      }
    }
    for (double alpha = 0.5; alpha > shortest; alpha *= 0.5) {
      w = point_.w + alpha * d;
      if (falls(w, alpha)) return take(w, alpha);
    }
    return false;
  }

  bool take(const VectorXd& w, double alpha) {
    point_.w = w.cwiseMax(program_.lower()).cwiseMin(program_.upper());
    point_.lambda += alpha * (next_.lambda - point_.lambda);
    point_.z += alpha * (next_.z - point_.z);
    return true;
  }

  NonlinearProgram& program_;
  const Sqp& options_;
  Curvature curvature_;
  Engine& engine_;
  const QpSolverFactory& relaxed_;
  QuadraticModel& model_;
  QpClock::time_point begin_ = QpClock::now();
  NlpPoint point_, next_;
  VectorXd price_;  // nu
  VectorXd rows_;
  QpClock::time_point deadline_;
  VectorXd exact_;        // Hessian before any care was taken
  double missing_ = 0.0;  // curvature on the surface of the equality rows
  KktResidual kkt_;
  double elastic_price_ = 0.0;
  int iterations_ = 0;
};

class SqpSolver final : public Solver {
 public:
  SqpSolver(const Sqp& options, QpSolverFactory qp, QpSolverFactory relaxed_qp)
      : options_(options), make_qp_(std::move(qp)), make_relaxed_qp_(std::move(relaxed_qp)) {}

  std::string name() const override { return engine_ ? "SQP with " + engine_->qp->name() : "SQP"; }

  void set_deadline(QpClock::time_point deadline) override { deadline_ = deadline; }

  NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm) override {
    Curvature curvature = options_.curvature;
    if (!program.supports(curvature))
      curvature = curvature == Curvature::exact ? Curvature::gauss_newton : Curvature::exact;
    if (!program.supports(curvature) || !is_well_posed(program, start)) return refuse(program);
    if (engine_ == nullptr || !engine_->fits(program))
      engine_ = std::make_unique<Engine>(program, options_, make_qp_);
    return Run(program, options_, curvature, *engine_, make_relaxed_qp_, deadline_)
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
  std::unique_ptr<Engine> engine_;
  QpClock::time_point deadline_ = QpClock::time_point::max();
};

}  // namespace

std::unique_ptr<Solver> make_solver(const Sqp& options, QpSolverFactory qp,
                                    QpSolverFactory relaxed_qp) {
  return std::make_unique<SqpSolver>(options, std::move(qp), std::move(relaxed_qp));
}

}  // namespace saltus
