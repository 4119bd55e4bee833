#include "saltus/solver/sqp_run.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/solver/verdict.hpp"

namespace saltus {
namespace {

constexpr double shortest_step = 1e-7;   // shorter steps mean that the model is wrong
constexpr double worthwhile_step = 0.1;  // below it a smaller trust region is tried first
constexpr double trust_shrinkage = 0.25, trust_growth = 2.0;
constexpr double trust_core = 0.1;  // shorter steps, in radii, do not depend on the trust region
constexpr double trust_edge = 0.9;  // longer steps, in radii, count as limited by the trust region
constexpr int exact_models = 8;     // models in smaller trust regions before convexification
constexpr double first_shift = 1e-4;  // in convexified models, relative to the largest entry
constexpr int convex_models = 9;
// Penalty weights of elastic mode, times the largest gradient and multiplier. They stay small, to
// avoid large weights in the merit function. The largest weight decides whether violations can be
// avoided at all.
constexpr double elastic_weight = 10.0, multiplier_weight = 2.0, largest_elastic_weight = 1e3;
constexpr double largest_estimate = 1e3;  // larger estimates of multipliers are rejected
constexpr double inexact = 1e-3;  // residual of an accepted model, relative to that of the program
constexpr double stalled = 1e-9;  // relative change of w or of its violation

double largest(const VectorXd& v) { return v.size() == 0 ? 0.0 : v.cwiseAbs().maxCoeff(); }

}  // namespace

SqpEngine::SqpEngine(const NonlinearProgram& program, const NativeSolverOptions& options)
    : model(program), qp_options{.tolerance = 0.01 * options.tolerance, .convex = false} {
  if (program.is_linear_quadratic())
    qp_options = {.tolerance = options.tolerance, .max_iterations = options.max_iterations};
  else
    convexification = std::make_unique<Convexification>(model.qp().hessian_pattern);
  qp = options.qp(program, model.qp().hessian_pattern, model.qp().row_pattern, qp_options);
  hessian_pattern = program.hessian_pattern();
  std::vector<char> meets(program.variables(), 0);
  hessian_pattern.for_each([&](int r, int c, int) {
    if (r != c) meets[r] = meets[c] = 1;
  });
  for (int i = 0; i < program.variables(); ++i)
    if (meets[i]) coupled.push_back(i);
}

bool SqpEngine::fits(const NonlinearProgram& p) const {
  return hessian_pattern == p.hessian_pattern() && model.qp().row_pattern == p.jacobian_pattern() &&
         p.is_linear_quadratic() == (convexification == nullptr);
}

SqpRun::SqpRun(NonlinearProgram& program, const NativeSolverOptions& options, Curvature curvature,
               SqpEngine& engine, WallClock::time_point deadline, const SolveObserver& observer,
               int first_number)
    : program_(program),
      options_(options),
      curvature_(curvature),
      engine_(engine),
      model_(engine.model),
      deadline_(deadline),
      observer_(observer),
      first_number_(first_number),
      merit_(program),
      rows_(VectorXd::Zero(program.rows())) {
  if (options.time_limit > 0.0)
    deadline_ = std::min(deadline_, seconds_after(begin_, options.time_limit));
  engine_.qp->set_deadline(deadline_);
}

NlpResult SqpRun::solve(const NlpPoint& start, bool warm) {
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
  if (program_.is_linear_quadratic() && observer_.report)  // a single model, reported once
    observer_.report({.number = first_number_ + iterations_,
                      .cost = result.objective,
                      .violation = result.kkt.feasibility,
                      .stationarity = result.kkt.stationarity,
                      .step = largest(point_.w - start.w),
                      .step_length = 1.0});
  result.point = std::move(point_);
  result.seconds = seconds_since(begin_);
  return result;
}

void SqpRun::report() const {
  SolveObserver::Iteration now{.number = first_number_ + iterations_,
                               .violation = kkt_.feasibility,
                               .stationarity = kkt_.stationarity,
                               .step = step_,
                               .regularisation = shift_,
                               .step_length = step_length_};
  program_.objective(point_.w.data(), now.cost);
  observer_.report(now);
}

SolveStatus SqpRun::solve_once(bool warm) {
  if (!model_.linearise(program_, VectorXd::Zero(program_.variables()), point_.lambda, curvature_))
    return SolveStatus::evaluation_failed;
  const NlpPoint start = point_;
  qp::QpResult r = engine_.qp->solve(model_.qp(), point_, warm);
  iterations_ = r.iterations;
  const bool broke =
      r.status == qp::QpStatus::numerical_failure || r.status == qp::QpStatus::iteration_limit;
  if (warm && broke) {  // a warm start may be worse than a cold one
    point_ = start;
    r = engine_.qp->solve(model_.qp(), point_, false);
    iterations_ += r.iterations;
  }
  if (r.status == qp::QpStatus::infeasible) {  // least violation, for the report
    point_ = start;
    NlpPoint relaxed = point_;
    const qp::QpResult least = solve_elastic(relaxed, true);
    iterations_ += least.iterations;
    if (serves(least)) point_ = relaxed;
  }
  return to_solve_status(r.status);
}

// Estimates multipliers that minimise |g + J'lambda + z| as if the rows held: those of the step
// along -g within the linearised rows. Without them the first model would ignore the curvature of
// the rows.
void SqpRun::estimate_multipliers() {
  if (!model_.linearise(program_, point_.w, point_.lambda, curvature_)) return;
  VectorXd& hessian = model_.qp().hessian;
  hessian.setZero();
  engine_.convexification->add_to_diagonal(hessian, 1.0);
  model_.hessian_changed();
  rows_ = model_.constraints().cwiseMax(program_.row_lower()).cwiseMin(program_.row_upper());
  model_.correct_rows(program_, point_.w, rows_);
  NlpPoint balanced = point_;
  const qp::QpResult r = engine_.qp->solve(model_.qp(), balanced, false);
  if (serves(r) && largest(balanced.lambda) <= largest_estimate) point_.lambda = balanced.lambda;
}

SolveStatus SqpRun::iterate(bool warm) {
  if (!warm) estimate_multipliers();
  radius_ = warm ? infinity : options_.initial_trust_radius;
  for (;; ++iterations_) {
    if (!model_.linearise(program_, point_.w, point_.lambda, curvature_))
      return SolveStatus::evaluation_failed;
    kkt_ = kkt_residual(program_, point_);
    if (observer_.report) report();
    if (kkt_.scaled() <= options_.tolerance && (warm || iterations_ > 0))
      return SolveStatus::optimal;
    if (timed_out()) return SolveStatus::time_limit;
    if (observer_.wants_stop()) return SolveStatus::interrupted;
    if (iterations_ >= options_.max_iterations) return SolveStatus::iteration_limit;
    const std::optional<SolveStatus> failure = step(warm || iterations_ > 0);
    if (!failure) continue;
    ++iterations_;  // its models were solved too
    if (failure == SolveStatus::numerical_failure &&
        kkt_.scaled() <= acceptable_multiple * options_.tolerance)
      return SolveStatus::acceptable;
    return *failure;
  }
}

// Takes one step and returns a status if no step was accepted. Models become more cautious until
// one succeeds: first with a smaller trust region, then convexified. From then on short steps are
// accepted as well.
std::optional<SolveStatus> SqpRun::step(bool warm) {
  exact_ = model_.qp().hessian;
  const double unit = std::max(1.0, largest(exact_));
  SolveStatus status = SolveStatus::numerical_failure;
  bool is_elastic = false;
  shift_ = 0.0;
  for (int model = 0; model < exact_models + convex_models; ++model) {
    const int care = model - exact_models;
    if (care < 0) {
      if (model > 0) radius_ = trust_shrinkage * std::min(radius_, length());
      set_trust_region(radius_);
    } else {
      if (care == 0) is_elastic = false;
      convexify(care == 0 ? 0.0 : first_shift * std::pow(10.0, care - 1) * unit);
      set_trust_region(infinity);
    }
    const qp::QpResult r = solve_model(is_elastic, care >= 0, warm);
    if (r.status == qp::QpStatus::deadline) return SolveStatus::time_limit;
    if (r.status == qp::QpStatus::invalid_problem) return SolveStatus::numerical_failure;
    // A nonconvex model does not prove it.
    if (r.status == qp::QpStatus::unbounded && care >= 0) status = SolveStatus::unbounded;
    if (!serves(r)) continue;
    if (is_elastic && is_stuck()) {
      if (care >= 0) return SolveStatus::infeasible;
      continue;
    }
    const double alpha = line_search(is_elastic, care >= 0 ? shortest_step : worthwhile_step);
    if (alpha > 0.0 && care >= 0) radius_ = infinity;  // trust regions did not help
    if (alpha > 0.0) return std::nullopt;
    status = SolveStatus::numerical_failure;
  }
  return status;
}

// Largest change of a coupled variable from the point to next_.
double SqpRun::length() const {
  double most = 0.0;
  for (const int i : engine_.coupled) most = std::max(most, std::abs(next_.w[i] - model_.w()[i]));
  return most;
}

// Sets the trust region, a box around the point of the model. Uncoupled variables have no uncertain
// curvature and are not restricted.
void SqpRun::set_trust_region(double radius) {
  model_.update_bounds(program_);
  if (radius == infinity) return;
  qp::SparseQp& qp = model_.qp();
  for (const int i : engine_.coupled) {
    qp.lower[i] = std::max(qp.lower[i], model_.w()[i] - radius);
    qp.upper[i] = std::min(qp.upper[i], model_.w()[i] + radius);
  }
}

// Solves the model from the point, in elastic mode if it has no feasible point.
qp::QpResult SqpRun::solve_model(bool& is_elastic, bool last_resort, bool warm) {
  qp::QpResult r;
  if (!is_elastic) {
    next_ = point_;
    r = engine_.qp->solve(model_.qp(), next_, warm);
    // A warm start may be worse than a cold one, or be accepted as the solution in the solver's
    // scale.
    const bool stays = next_.w == point_.w;
    if (warm && (!serves(r) || stays) && r.status != qp::QpStatus::deadline) {
      next_ = point_;
      r = engine_.qp->solve(model_.qp(), next_, false);
    }
    is_elastic = r.status == qp::QpStatus::infeasible;
  }
  if (!is_elastic) {
    if (serves(r)) largest_multiplier_ = largest(next_.lambda);
    return r;
  }
  next_ = point_;
  return solve_elastic(next_, last_resort);
}

bool SqpRun::serves(const qp::QpResult& r) const {
  return r.status == qp::QpStatus::optimal ||
         r.residual <= std::max(options_.tolerance, inexact * kkt_.scaled());
}

// Convexifies the Hessian by blocks and shifts it.
void SqpRun::convexify(double shift) {
  VectorXd& hessian = model_.qp().hessian;
  hessian = exact_;
  engine_.convexification->apply(hessian, options_.convexity_floor);
  engine_.convexification->add_to_diagonal(hessian, shift);
  model_.hessian_changed();
  shift_ = shift;
}

qp::QpResult SqpRun::solve_elastic(NlpPoint& point, bool last_resort) {
  if (engine_.elastic == nullptr)
    engine_.elastic =
        std::make_unique<ElasticQp>(program_, model_.qp(), options_.elastic_qp, engine_.qp_options);
  const double factor = last_resort ? largest_elastic_weight : elastic_weight;
  elastic_weight_ = std::max(
      {factor, factor * largest(model_.gradient()), multiplier_weight * largest_multiplier_});
  return engine_.elastic->solve(model_.qp(), elastic_weight_, point, deadline_);
}

// True if the relaxed model, and therefore the program, cannot reduce the violation.
bool SqpRun::is_stuck() {
  multiply(model_.qp().row_pattern, model_.qp().rows, next_.w - point_.w, rows_);
  rows_ += model_.constraints();
  const double before = total_violation(program_, model_.constraints());
  return before > options_.tolerance &&
         (total_violation(program_, rows_) >= (1.0 - 1e-6) * before ||
          largest(next_.w - point_.w) <= stalled * (1.0 + largest(point_.w)));
}

// Line search on the merit function towards next_, down to the step length `shortest`. Returns the
// accepted step length, 0 if none.
double SqpRun::line_search(bool is_elastic, double shortest) {
  merit_.update_weights(next_.lambda, is_elastic ? elastic_weight_ : 0.0);
  merit_.start_at(program_, model_);
  const double predicted = merit_.predicted_change(program_, model_, next_.w);
  if (predicted > merit_.noise()) return 0.0;
  if (merit_.decreases_enough(program_, next_.w, predicted)) return accept(next_.w, 1.0);
  if (!is_elastic && correct_second_order(predicted)) return accept(next_.w, 1.0);
  const VectorXd d = next_.w - point_.w;
  for (double alpha = 0.5; alpha > shortest; alpha *= 0.5) {
    trial_ = point_.w + alpha * d;
    if (merit_.decreases_enough(program_, trial_, alpha * predicted)) return accept(trial_, alpha);
  }
  return 0.0;
}

// Second-order correction of a step that fails because of its rows, as last evaluated.
bool SqpRun::correct_second_order(double predicted) {
  if (!merit_.rows().allFinite()) return false;
  NlpPoint other = next_;
  model_.correct_rows(program_, next_.w, merit_.rows());
  const qp::QpResult r = engine_.qp->solve(model_.qp(), other, true);
  model_.correct_rows(program_, model_.w(), model_.constraints());
  if (!serves(r) || !merit_.decreases_enough(program_, other.w, predicted)) return false;
  next_ = std::move(other);
  return true;
}

// Adapts the trust region to the accepted step.
double SqpRun::accept(const VectorXd& w, double alpha) {
  const double size = length();
  step_ = largest(next_.w - point_.w);
  step_length_ = alpha;
  if (alpha < 1.0)
    radius_ = std::min(radius_, trust_growth * alpha * size);
  else if (size <= trust_core * radius_)
    radius_ = infinity;
  else if (size >= trust_edge * radius_)
    radius_ *= trust_growth;
  point_.w = w.cwiseMax(program_.lower()).cwiseMin(program_.upper());
  point_.lambda += alpha * (next_.lambda - point_.lambda);
  point_.z += alpha * (next_.z - point_.z);
  return alpha;
}

}  // namespace saltus
