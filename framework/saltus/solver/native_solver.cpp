#include "saltus/solver/native_solver.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "saltus/solver/barrier_run.hpp"
#include "saltus/solver/check_limits.hpp"
#include "saltus/solver/differenced_program.hpp"
#include "saltus/solver/scaled_program.hpp"
#include "saltus/solver/sqp_run.hpp"
#include "saltus/solver/verdict.hpp"
#include "saltus/solver/well_posed.hpp"

namespace saltus {
namespace {

// Number of models of a warm start before the barrier method takes over.
constexpr int warm_models = 30;
constexpr int refining_models = 10;
// First barrier parameter of the second attempt after a cold start. It is larger: the path stays
// farther from the bounds and avoids local minima of the violation.
constexpr double farther_barrier = 1.0;
// The barrier method is not scale-invariant: slopes at its start are limited to this.
constexpr double largest_slope = 100.0, least_scale = 1e-8;

double scale_for(double slope) {
  return std::isfinite(slope) && slope > largest_slope
             ? std::max(largest_slope / slope, least_scale)
             : 1.0;
}

ProgramScale limit_slopes(NonlinearProgram& program, const VectorXd& w) {
  ProgramScale scale{1.0, VectorXd::Ones(program.rows())};
  VectorXd gradient(program.variables());
  std::vector<double> entries(program.jacobian_pattern().entries());
  if (!program.gradient(w.data(), gradient.data()) || !program.jacobian(w.data(), entries.data()))
    return scale;
  const auto is_free = [&](int i) { return program.lower()[i] < program.upper()[i]; };
  double slope = 0.0;
  for (int i = 0; i < program.first_slack(); ++i)
    if (is_free(i)) slope = std::max(slope, std::abs(gradient[i]));
  scale.cost = scale_for(slope);
  VectorXd steepest = VectorXd::Zero(program.rows());
  program.jacobian_pattern().for_each([&](int r, int c, int e) {
    if (is_free(c)) steepest[r] = std::max(steepest[r], std::abs(entries[e]));
  });
  for (int i = 0; i < program.rows(); ++i) scale.rows[i] = scale_for(steepest[i]);
  return scale;
}

class NativeSolver final : public Solver {
 public:
  explicit NativeSolver(NativeSolverOptions options) : options_(std::move(options)) {}

  std::string name() const override {
    return engine_ ? "native solver with " + engine_->qp->name() : "native solver";
  }

  double tolerance() const override { return options_.tolerance; }
  bool keeps_stages() const override { return options_.qp.by_stages; }

  void set_deadline(WallClock::time_point deadline) override { deadline_ = deadline; }

  NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm) override {
    if (!is_well_posed(program, start) || !start.w.allFinite()) return refuse(program);
    if (const auto curvature = supported_curvature(program, options_.curvature))
      return judged(solve(program, start, warm, *curvature));
    DifferencedProgram differenced(program);
    NlpResult result = judged(solve(differenced, start, warm, Curvature::exact));
    result.hessian = "differenced";
    return result;
  }

 private:
  NlpResult judged(NlpResult result) const {
    result.status = status_by_residual(result.status, result.kkt, options_.tolerance,
                                       result.iterations >= options_.max_iterations
                                           ? SolveStatus::iteration_limit
                                           : SolveStatus::numerical_failure);
    return result;
  }

  NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm,
                  Curvature curvature) {
    if (engine_ == nullptr || !engine_->fits(program))
      engine_ = std::make_unique<SqpEngine>(program, options_);
    const WallClock::time_point begin = WallClock::now();
    WallClock::time_point deadline = deadline_;
    if (options_.time_limit > 0.0)
      deadline = std::min(deadline, seconds_after(begin, options_.time_limit));
    if (program.is_linear_quadratic() || !options_.qp.make_newton) {
      NlpResult result =
          SqpRun(program, options_, curvature, *engine_, deadline, observer()).solve(start, warm);
      // One model is sufficient unless it is not convex.
      const bool gave_up = result.status == SolveStatus::numerical_failure ||
                           result.status == SolveStatus::unbounded;
      if (!gave_up || !options_.qp.make_newton) return result;
      NlpResult other = solve_by_barrier(program, start, curvature, left_after(result), deadline,
                                         result.iterations);
      // A proven result is kept.
      if (result.status == SolveStatus::unbounded && has_given_up(other.status))
        other.status = SolveStatus::unbounded;
      return after(result, std::move(other));
    }
    if (!warm || start.lambda.size() != program.rows())
      return refined(program, curvature, deadline, solve_cold(program, start, curvature, deadline));

    NativeSolverOptions few = options_;
    few.max_iterations = std::min(options_.max_iterations, warm_models);
    NlpResult result =
        SqpRun(program, few, curvature, *engine_, deadline, observer()).solve(start, true);
    const bool is_final = is_success(result.status) || result.status == SolveStatus::time_limit ||
                          result.status == SolveStatus::interrupted ||
                          result.iterations >= options_.max_iterations;
    if (is_final) return result;
    return after(result, solve_by_barrier(program, start, curvature, left_after(result), deadline,
                                          result.iterations));
  }

  // The restoration may end at a local minimum of the violation. A second path is therefore tried
  // before a program is reported as infeasible.
  NlpResult solve_cold(NonlinearProgram& program, const NlpPoint& start, Curvature curvature,
                       WallClock::time_point deadline) {
    NlpResult result =
        solve_by_barrier(program, start, curvature, options_.max_iterations, deadline);
    const bool is_worth_it =
        result.status == SolveStatus::infeasible || result.status == SolveStatus::numerical_failure;
    if (!is_worth_it || left_after(result) == 0) return result;
    NlpResult other = solve_by_barrier(program, start, curvature, left_after(result), deadline,
                                       result.iterations, farther_barrier);
    if (is_success(other.status) || other.status == SolveStatus::interrupted)
      return after(result, std::move(other));
    return after(other, std::move(result));
  }

  int left_after(const NlpResult& before) const {
    return std::max(0, options_.max_iterations - before.iterations);
  }
  // True if the solver failed, but not because of the time limit, an interruption or infeasibility.
  static bool has_given_up(SolveStatus status) {
    return !is_success(status) && status != SolveStatus::time_limit &&
           status != SolveStatus::interrupted && status != SolveStatus::infeasible;
  }

  // Adds the effort of another attempt to the result.
  static NlpResult after(const NlpResult& other, NlpResult result) {
    result.iterations += other.iterations;
    result.seconds += other.seconds;
    return result;
  }

  // The barrier method terminates by its own scaling. If the program's residual is too large, a few
  // models solved to convergence reduce it.
  NlpResult refined(NonlinearProgram& program, Curvature curvature, WallClock::time_point deadline,
                    NlpResult result) {
    if (result.status != SolveStatus::optimal && result.status != SolveStatus::acceptable)
      return result;
    if (result.kkt.scaled() <= options_.tolerance) return result;
    NativeSolverOptions few = options_;
    few.max_iterations = std::min(refining_models, left_after(result));
    NlpResult better =
        SqpRun(program, few, curvature, *engine_, deadline, observer(), result.iterations)
            .solve(result.point, true);
    if (better.status != SolveStatus::optimal) return after(better, std::move(result));
    return after(result, std::move(better));
  }

  NlpResult solve_by_barrier(NonlinearProgram& program, const NlpPoint& start, Curvature curvature,
                             int max_iterations, WallClock::time_point deadline,
                             int first_number = 0,
                             double first_barrier = BarrierOptions().first_barrier) {
    const WallClock::time_point begin = WallClock::now();
    if (engine_->barrier == nullptr)
      engine_->barrier = std::make_unique<BarrierEngine>(
          program, options_.qp.make_newton(program, BarrierEngine::full_hessian(program),
                                           program.jacobian_pattern()));
    BarrierOptions options;
    options.tolerance = options_.tolerance;
    options.max_iterations = max_iterations;
    options.deadline = deadline;
    options.first_barrier = first_barrier;
    const VectorXd inside = start.w.cwiseMax(program.lower()).cwiseMin(program.upper());
    const ProgramScale scale = limit_slopes(program, inside);
    ScaledProgram scaled(program, scale);
    const SolveObserver unscaling = with_cost_times(observer(), 1.0 / scale.cost);
    options.observer = &unscaling;
    options.first_number = first_number;
    BarrierRun run(scaled, curvature, *engine_->barrier, options);
    NlpResult result;
    result.status = run.solve(start);
    result.point = scaled.from_scaled(run.point());
    result.iterations = run.iterations();
    result.hessian = curvature == Curvature::exact ? "exact" : "Gauss-Newton";
    result.kkt = kkt_residual(program, result.point);
    if (!program.objective(result.point.w.data(), result.objective) && is_success(result.status))
      result.status = SolveStatus::evaluation_failed;
    result.status = status_by_descent(result.status, program, inside, result.objective);
    result.seconds = seconds_since(begin);
    return result;
  }

  static NlpResult refuse(const NonlinearProgram& program) {
    NlpResult result;
    result.point = {VectorXd::Zero(program.variables()), VectorXd::Zero(program.rows()),
                    VectorXd::Zero(program.variables())};
    return result;
  }

  NativeSolverOptions options_;
  std::unique_ptr<SqpEngine> engine_;
  WallClock::time_point deadline_ = WallClock::time_point::max();
};

}  // namespace

std::unique_ptr<Solver> make_native_solver(NativeSolverOptions options) {
  check_limits(options.tolerance, options.max_iterations, options.time_limit);
  return std::make_unique<NativeSolver>(std::move(options));
}

std::unique_ptr<Solver> make_sqp(NativeSolverOptions options) {
  return make_native_solver(std::move(options));
}

}  // namespace saltus
