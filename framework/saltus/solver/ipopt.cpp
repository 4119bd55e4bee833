#include "saltus/solver/ipopt.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <exception>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"
#include "saltus/solver/blas_memory.hpp"
#include "saltus/solver/check_limits.hpp"
#include "saltus/solver/verdict.hpp"
#include "saltus/solver/well_posed.hpp"

// The include folder (coin/ before Ipopt 3.14, coin-or/ since) comes from the flags of the package.
#include <IpIpoptApplication.hpp>
#include <IpTNLP.hpp>

// Defined if the linear solver uses OpenBLAS; null with any other BLAS.
extern "C" void openblas_set_num_threads(int threads) __attribute__((weak));

// Short name of Ipopt's namespace.
namespace coin = ::Ipopt;

namespace saltus {
namespace {

using coin::Index;
using coin::Number;

// Adapter of a NonlinearProgram to Ipopt. Ipopt's multipliers z_L, z_U >= 0 become z = z_U - z_L.
// Rows without sides are left out: Ipopt would add a slack and a multiplier for each of them, so
// that idle rows would change its iterates.
class Adapter final : public coin::TNLP {
 public:
  Adapter(NonlinearProgram& program, Curvature curvature, double time_limit)
      : program_(program), curvature_(curvature), time_limit_(time_limit) {}

  NlpResult result;
  bool timed_out = false, was_interrupted = false;
  const SolveObserver* observer = nullptr;
  std::exception_ptr thrown;  // exception of a formula, which Ipopt would discard
  WallClock::time_point deadline = WallClock::time_point::max();

  /// Must be called before every solve; `start` must outlive it.
  void begin(const NlpPoint& start) {
    start_ = &start;
    result = {};
    timed_out = was_interrupted = false;
    thrown = nullptr;
    find_rows_with_sides();
    begin_ = WallClock::now();
  }

  bool get_nlp_info(Index& n, Index& m, Index& jacobian_entries, Index& hessian_entries,
                    IndexStyleEnum& style) override {
    n = program_.variables();
    m = static_cast<Index>(row_of_.size());
    jacobian_entries = static_cast<Index>(entry_of_.size());
    hessian_entries = program_.hessian_pattern().entries();
    style = TNLP::C_STYLE;
    return true;
  }

  bool get_bounds_info(Index n, Number* lower, Number* upper, Index m, Number* row_lower,
                       Number* row_upper) override {
    std::copy_n(program_.lower().data(), n, lower);
    std::copy_n(program_.upper().data(), n, upper);
    for (Index i = 0; i < m; ++i) {
      row_lower[i] = program_.row_lower()[row_of_[i]];
      row_upper[i] = program_.row_upper()[row_of_[i]];
    }
    return true;
  }

  bool get_starting_point(Index n, bool init_w, Number* w, bool init_z, Number* z_lower,
                          Number* z_upper, Index m, bool init_lambda, Number* lambda) override {
    if (init_w) std::copy_n(start_->w.data(), n, w);
    if (init_z)
      for (int i = 0; i < n; ++i) {
        const double z = start_->z.size() == n ? start_->z[i] : 0.0;
        z_upper[i] = std::max(z, 0.0);
        z_lower[i] = std::max(-z, 0.0);
      }
    const bool is_known = start_->lambda.size() == program_.rows();
    for (Index i = 0; init_lambda && i < m; ++i)
      lambda[i] = is_known ? start_->lambda[row_of_[i]] : 0.0;
    return true;
  }

  bool eval_f(Index, const Number* w, bool, Number& f) override {
    return keep([&] { return program_.objective(w, f) && std::isfinite(f); });
  }
  bool eval_grad_f(Index, const Number* w, bool, Number* gradient) override {
    return keep([&] { return program_.gradient(w, gradient); });
  }
  bool eval_g(Index, const Number* w, bool, Index m, Number* g) override {
    return keep([&] {
      const bool is_known = program_.constraints(w, rows_.data());
      for (Index i = 0; i < m; ++i) g[i] = rows_[row_of_[i]];
      return is_known;
    });
  }
  bool eval_jac_g(Index, const Number* w, bool, Index, Index count, Index* rows, Index* cols,
                  Number* entries) override {
    if (entries == nullptr) {
      for (Index k = 0; k < count; ++k) {
        rows[k] = entry_of_[k].row;
        cols[k] = entry_of_[k].col;
      }
      return true;
    }
    return keep([&] {
      const bool is_known = program_.jacobian(w, jacobian_.data());
      for (Index k = 0; k < count; ++k) entries[k] = jacobian_[entry_of_[k].at];
      return is_known;
    });
  }
  bool eval_h(Index, const Number* w, bool, Number sigma, Index, const Number* lambda, bool, Index,
              Index* rows, Index* cols, Number* entries) override {
    if (entries == nullptr) {
      program_.hessian_pattern().for_each([&](int r, int c, int e) {
        rows[e] = r;
        cols[e] = c;
      });
      return true;
    }
    return keep([&] {
      const VectorXd of_rows = on_all_rows(lambda);
      return program_.hessian(w, sigma, of_rows.data(), entries, curvature_);
    });
  }

  bool intermediate_callback(coin::AlgorithmMode mode, Index iteration, Number cost,
                             Number violation, Number stationarity, Number barrier, Number step,
                             Number shift, Number dual_step_length, Number step_length, Index,
                             const coin::IpoptData*, coin::IpoptCalculatedQuantities*) override {
    result.iterations = iteration;
    keep([&] {
      if (observer->report)
        observer->report({.number = iteration,
                          .is_restoring = mode == coin::RestorationPhaseMode,
                          .cost = cost,
                          .violation = violation,
                          .stationarity = stationarity,
                          .barrier = barrier,
                          .step = step,
                          .regularisation = shift,
                          .step_length = step_length,
                          .dual_step_length = dual_step_length});
      was_interrupted = observer->wants_stop();
      return true;
    });
    timed_out =
        (time_limit_ > 0.0 && seconds_since(begin_) > time_limit_) || WallClock::now() >= deadline;
    return !timed_out && !was_interrupted && !thrown;
  }

  void finalize_solution(coin::SolverReturn, Index n, const Number* w, const Number* z_lower,
                         const Number* z_upper, Index, const Number*, const Number* lambda,
                         Number f, const coin::IpoptData*,
                         coin::IpoptCalculatedQuantities*) override {
    using ConstMap = Eigen::Map<const VectorXd>;
    result.point = {ConstMap(w, n), on_all_rows(lambda),
                    ConstMap(z_upper, n) - ConstMap(z_lower, n)};
    result.objective = f;
  }

 private:
  // Evaluates unless a previous evaluation has thrown.
  template <class Evaluate>
  bool keep(Evaluate&& evaluate) noexcept {
    if (thrown) return false;
    try {
      return evaluate();
    } catch (...) {
      thrown = std::current_exception();
      return false;
    }
  }

  struct JacobianEntry {
    Index row, col;  // in Ipopt's problem
    int at;          // index in the program's array
  };

  void find_rows_with_sides() {
    rows_.resize(program_.rows());
    jacobian_.resize(program_.jacobian_pattern().entries());
    row_of_.clear();
    entry_of_.clear();
    const SparsityPattern& pattern = program_.jacobian_pattern();
    for (int r = 0; r < program_.rows(); ++r) {
      if (program_.row_lower()[r] == -infinity && program_.row_upper()[r] == infinity) continue;
      const Index row = static_cast<Index>(row_of_.size());
      row_of_.push_back(r);
      for (int e = pattern.row_begin(r); e < pattern.row_end(r); ++e)
        entry_of_.push_back({row, pattern.col(e), e});
    }
  }

  // The multipliers of all rows, zero where a row has no side.
  VectorXd on_all_rows(const Number* lambda) const {
    VectorXd all = VectorXd::Zero(program_.rows());
    for (std::size_t i = 0; i < row_of_.size(); ++i) all[row_of_[i]] = lambda[i];
    return all;
  }

  NonlinearProgram& program_;
  const NlpPoint* start_ = nullptr;
  Curvature curvature_;
  double time_limit_;
  WallClock::time_point begin_ = WallClock::now();
  std::vector<int> row_of_;  // row of the program for each row of Ipopt's problem
  std::vector<JacobianEntry> entry_of_;
  VectorXd rows_, jacobian_;  // values of the program
};

SolveStatus translate(coin::ApplicationReturnStatus status, bool timed_out) {
  switch (status) {
    case coin::Solve_Succeeded:
    case coin::Feasible_Point_Found:
      return SolveStatus::optimal;
    case coin::Solved_To_Acceptable_Level:
      return SolveStatus::acceptable;
    case coin::Infeasible_Problem_Detected:
      return SolveStatus::infeasible;
    case coin::Diverging_Iterates:
      return SolveStatus::unbounded;
    case coin::Maximum_Iterations_Exceeded:
      return SolveStatus::iteration_limit;
    case coin::Maximum_CpuTime_Exceeded:
      return SolveStatus::time_limit;
    case coin::User_Requested_Stop:
      return timed_out ? SolveStatus::time_limit : SolveStatus::numerical_failure;
    case coin::Invalid_Number_Detected:
      return SolveStatus::evaluation_failed;
    case coin::Not_Enough_Degrees_Of_Freedom:
    case coin::Invalid_Problem_Definition:
    case coin::Invalid_Option:
      return SolveStatus::invalid_problem;
    default:
      return SolveStatus::numerical_failure;
  }
}

// True if Ipopt has the option and accepts the value as a text, integer or number.
bool set_named(coin::OptionsList& options, const std::string& name, const std::string& value) {
  if (options.SetStringValue(name, value)) return true;
  char* end = nullptr;
  const long whole = std::strtol(value.c_str(), &end, 10);
  if (!value.empty() && *end == '\0' && options.SetIntegerValue(name, static_cast<Index>(whole)))
    return true;
  const double number = std::strtod(value.c_str(), &end);
  return !value.empty() && *end == '\0' && options.SetNumericValue(name, number);
}

// Properties from which Ipopt derives its internal problem: patterns, bounded sides, fixed
// variables.
class Structure {
 public:
  Structure() = default;
  explicit Structure(const NonlinearProgram& p)
      : jacobian_(p.jacobian_pattern()), hessian_(p.hessian_pattern()) {
    append(p.lower(), p.upper());
    append(p.row_lower(), p.row_upper());
  }
  bool has_patterns_of(const NonlinearProgram& p) const {
    return jacobian_ == p.jacobian_pattern() && hessian_ == p.hessian_pattern();
  }
  friend bool operator==(const Structure&, const Structure&) = default;

 private:
  void append(const VectorXd& lower, const VectorXd& upper) {
    for (int i = 0; i < lower.size(); ++i)
      sides_.push_back(static_cast<char>((std::isfinite(lower[i]) ? 1 : 0) +
                                         (std::isfinite(upper[i]) ? 2 : 0) +
                                         (lower[i] == upper[i] ? 4 : 0)));
  }
  SparsityPattern jacobian_, hessian_;
  std::vector<char> sides_;
};

class IpoptSolver final : public Solver {
 public:
  explicit IpoptSolver(const IpoptOptions& options) : options_(options) {}

  std::string name() const override { return "Ipopt"; }
  double tolerance() const override { return options_.tolerance; }
  void set_deadline(WallClock::time_point deadline) override { deadline_ = deadline; }

  NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm) override {
    NlpResult result = solve(program, start, warm, engine_, options_.bound_relaxation);
    if (!has_no_interior(result)) return result;
    Engine relaxed;
    NlpResult again = solve(program, start, warm, relaxed, interior * options_.tolerance);
    again.iterations += result.iterations;
    again.seconds += result.seconds;
    if (is_success(again.status)) return again;
    result.iterations = again.iterations;
    result.seconds = again.seconds;
    return result;
  }

 private:
  // Bounds are relaxed by this fraction of the tolerance, relative to their magnitude, where the
  // constraints leave no interior.
  static constexpr double interior = 0.1;

  // True if the solver stopped at a point that satisfies the constraints, with diverging
  // multipliers. Multipliers of constraints without an interior are unbounded.
  bool has_no_interior(const NlpResult& result) const {
    static constexpr double diverging = 1e10;
    if (result.status != SolveStatus::iteration_limit &&
        result.status != SolveStatus::numerical_failure)
      return false;
    const auto diverges = [](const VectorXd& multipliers) {
      return (multipliers.array().abs() > diverging).any();
    };
    return options_.bound_relaxation == 0.0 && result.kkt.feasibility <= options_.tolerance &&
           (diverges(result.point.lambda) || diverges(result.point.z));
  }

  struct Engine;
  NlpResult solve(NonlinearProgram& program, const NlpPoint& start, bool warm, Engine& engine,
                  double relaxation) {
    const WallClock::time_point begin = WallClock::now();
    const BlasMemory memory;
    if (options_.blas_threads > 0 && openblas_set_num_threads != nullptr)
      openblas_set_num_threads(options_.blas_threads);
    const bool limited_memory = !program.supports(options_.curvature);
    SolveStatus status = SolveStatus::invalid_problem;
    NlpResult result;
    if (is_well_posed(program, start)) {  // otherwise Ipopt reports an internal error or ignores it
      if (!engine.fits(program, warm)) engine = open(program, warm, limited_memory, relaxation);
      if (IsValid(engine.application)) {
        engine.adapter->begin(start);
        engine.adapter->deadline = deadline_;
        engine.adapter->observer = &observer();
        const coin::ApplicationReturnStatus code = engine.run(Structure(program));
        status = translate(code, engine.adapter->timed_out);  // timed_out is set only now
        if (engine.adapter->was_interrupted) status = SolveStatus::interrupted;
        result = std::move(engine.adapter->result);
        if (engine.adapter->thrown) {
          const std::exception_ptr thrown = std::exchange(engine, {}).adapter->thrown;
          std::rethrow_exception(thrown);
        }
      }
    }
    result.status = status;
    result.hessian = limited_memory                                  ? "limited-memory BFGS"
                     : options_.curvature == Curvature::gauss_newton ? "Gauss-Newton"
                                                                     : "exact";
    if (result.point.w.size() != program.variables()) {  // Ipopt stopped before the first iterate
      result.point = {start.w, VectorXd::Zero(program.rows()), VectorXd::Zero(program.variables())};
      if (start.w.size() != program.variables())
        result.point.w = VectorXd::Zero(program.variables());
      if (!program.objective(result.point.w.data(), result.objective))
        result.status = SolveStatus::evaluation_failed;
    }
    result.kkt = kkt_residual(program, result.point);
    result.status = status_by_descent(result.status, program, start.w, result.objective);
    result.status = status_by_residual(result.status, result.kkt, options_.tolerance,
                                       SolveStatus::numerical_failure);
    result.seconds = seconds_since(begin);
    return result;
  }

  // Ipopt with its options, kept between solves of one program. Its symbolic work is kept too while
  // the fixed variables and bounded sides stay the same.
  struct Engine {
    const NonlinearProgram* program = nullptr;
    bool warm = false;
    coin::SmartPtr<coin::IpoptApplication> application;
    coin::SmartPtr<Adapter> adapter;
    Structure solved;

    bool fits(const NonlinearProgram& p, bool w) const {
      return program == &p && warm == w && solved.has_patterns_of(p);
    }
    coin::ApplicationReturnStatus run(Structure structure) {
      const bool same = structure == solved;
      solved = std::move(structure);
      application->Options()->SetStringValue("warm_start_same_structure", same ? "yes" : "no");
      return same ? application->ReOptimizeTNLP(adapter) : application->OptimizeTNLP(adapter);
    }
  };

  Engine open(NonlinearProgram& program, bool warm, bool limited_memory, double relaxation) const {
    Engine engine{&program, warm, configured(warm, limited_memory, relaxation), nullptr, {}};
    engine.adapter = new Adapter(program, options_.curvature, options_.time_limit);
    return engine;
  }

  coin::SmartPtr<coin::IpoptApplication> configured(bool warm, bool limited_memory,
                                                    double relaxation) const {
    // No console output: a library does not print. A print level above 0 is an explicit request.
    coin::SmartPtr<coin::IpoptApplication> app =
        new coin::IpoptApplication(options_.print_level > 0);
    coin::SmartPtr<coin::OptionsList> o = app->Options();
    bool ok = o->SetIntegerValue("print_level", options_.print_level);
    ok = o->SetStringValue("sb", "yes") && ok;
    ok = o->SetNumericValue("tol", options_.tolerance) && ok;
    // The scaled error alone may hide a large unscaled one, so both are limited.
    const double acceptable = acceptable_multiple * options_.tolerance;
    ok = o->SetNumericValue("dual_inf_tol", acceptable) && ok;
    ok = o->SetNumericValue("constr_viol_tol", std::min(1e-4, options_.tolerance)) && ok;
    ok = o->SetNumericValue("compl_inf_tol", acceptable) && ok;
    for (const char* looser : {"acceptable_tol", "acceptable_dual_inf_tol",
                               "acceptable_constr_viol_tol", "acceptable_compl_inf_tol"})
      ok = o->SetNumericValue(looser, acceptable) && ok;
    ok = o->SetIntegerValue("max_iter", options_.max_iterations) && ok;
    ok = o->SetNumericValue("bound_relax_factor", relaxation) && ok;
    if (options_.mehrotra)
      ok = o->SetStringValue("mehrotra_algorithm", "yes") && ok;
    else
      ok = o->SetStringValue("mu_strategy", options_.adaptive_barrier ? "adaptive" : "monotone") &&
           ok;
    ok = o->SetStringValue("hessian_approximation", limited_memory ? "limited-memory" : "exact") &&
         ok;
    // Fixed inputs are removed from the problem.
    ok = o->SetStringValue("fixed_variable_treatment", "make_parameter") && ok;
    if (warm) {
      ok = o->SetStringValue("warm_start_init_point", "yes") && ok;
      ok = o->SetNumericValue("mu_init", options_.warm_start_barrier) && ok;
      // Distance by which the start is moved inside its bounds: the same as that of the barrier.
      for (const char* push :
           {"warm_start_bound_push", "warm_start_bound_frac", "warm_start_slack_bound_push",
            "warm_start_slack_bound_frac", "warm_start_mult_bound_push"})
        ok = o->SetNumericValue(push, options_.warm_start_barrier) && ok;
    }
    for (const auto& [name, value] : options_.named) ok = set_named(*o, name, value) && ok;
    if (!ok || app->Initialize("") != coin::Solve_Succeeded) return nullptr;
    return app;
  }

  IpoptOptions options_;
  WallClock::time_point deadline_ = WallClock::time_point::max();
  Engine engine_;
};

}  // namespace

std::unique_ptr<Solver> make_ipopt(const IpoptOptions& options) {
  check_limits(options.tolerance, options.max_iterations, options.time_limit);
  if (!options.named.empty()) {
    const coin::SmartPtr<coin::IpoptApplication> trial = new coin::IpoptApplication(false);
    for (const auto& [name, value] : options.named)
      if (!set_named(*trial->Options(), name, value))
        throw DefinitionError(fmt::format(
            "Ipopt rejects the option '{}' with the value '{}'; its options are listed by "
            "`ipopt --print-options` and in its documentation",
            name, value));
  }
  return std::make_unique<IpoptSolver>(options);
}

}  // namespace saltus
