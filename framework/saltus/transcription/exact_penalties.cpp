#include "saltus/transcription/exact_penalties.hpp"

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "saltus/solver/presolve.hpp"
#include "saltus/transcription/quantities.hpp"

namespace saltus {
namespace {

constexpr double first_weight = 1e3;  // times the largest derivative of the cost
constexpr double growth = 1e3;        // factor for weights that are too small
// A penalty counts as exact if the bound multiplier of its slack exceeds this fraction of the
// weight.
constexpr double held = 1e-3;

// Lowers weights and restores them in the destructor.
class LoweredWeights {
 public:
  explicit LoweredWeights(ShootingProgram& program) : program_(program) {}
  ~LoweredWeights() { restore(); }
  LoweredWeights(const LoweredWeights&) = delete;
  LoweredWeights& operator=(const LoweredWeights&) = delete;

  void lower(double most) {
    program_.limit_linear_weights(most);
    are_lowered_ = true;
  }
  void restore() {
    if (are_lowered_) program_.limit_linear_weights(infinity);
    are_lowered_ = false;
  }

 private:
  ShootingProgram& program_;
  bool are_lowered_ = false;
};

// Largest derivative of the cost at the start, without penalties.
double size_of_cost(ShootingProgram& program, const VectorXd& w) {
  VectorXd gradient(program.variables());
  if (w.size() != program.variables() || !program.gradient(w.data(), gradient.data()) ||
      !gradient.allFinite() || program.first_slack() == 0)
    return 1.0;
  return std::max(1.0, gradient.head(program.first_slack()).cwiseAbs().maxCoeff());
}

// True if every lowered penalty is exact with margin.
bool is_exact(ShootingProgram& program, const std::vector<int>& lowered, const NlpPoint& point) {
  VectorXd gradient(program.variables());
  if (point.z.size() != program.variables() || !program.gradient(point.w.data(), gradient.data()))
    return false;
  return std::all_of(lowered.begin(), lowered.end(),
                     [&](int slack) { return -point.z[slack] > held * std::abs(gradient[slack]); });
}

// Sets the slacks of exact penalties to zero, with multipliers for the weights of the problem.
void complete(ShootingProgram& program, const std::vector<int>& lowered, NlpPoint& point) {
  for (const int slack : lowered) point.w[slack] = program.lower()[slack];
  VectorXd balance(program.variables());
  std::vector<double> jacobian(program.jacobian_pattern().entries());
  if (!program.gradient(point.w.data(), balance.data()) ||
      !program.jacobian(point.w.data(), jacobian.data()))
    return;
  program.jacobian_pattern().for_each(
      [&](int r, int c, int e) { balance[c] += point.lambda[r] * jacobian[e]; });
  for (const int slack : lowered) point.z[slack] = -balance[slack];
}

// Outcomes that other weights do not change: the solve was stopped, or hard rows are infeasible.
bool is_final(SolveStatus status) {
  return status == SolveStatus::time_limit || status == SolveStatus::interrupted ||
         status == SolveStatus::infeasible || status == SolveStatus::invalid_problem;
}

// Sets cost and residual for the weights of the program, and the total effort of all solves.
void describe_end(ShootingProgram& program, int iterations, double seconds, NlpResult& result) {
  if (result.point.w.size() == program.variables()) {
    result.kkt = kkt_residual(program, result.point);
    program.objective(result.point.w.data(), result.objective);
  }
  result.iterations = iterations;
  result.seconds = seconds;
}

}  // namespace

ScaledResult solve_with_penalties(Solver& solver, ShootingProgram& program, const NlpPoint& start,
                                  bool warm, bool in_scale) {
  const Quantities quantities = undeclared_quantities(program);
  const auto solve_from = [&](const NlpPoint& point, bool with_multipliers) {
    return solve_presolved(solver, program, point, [&](NonlinearProgram& reduced) {
      return in_scale ? solve_in_scale(solver, reduced, point, with_multipliers, quantities)
                      : solve_as_stated(solver, reduced, point, with_multipliers, quantities);
    });
  };
  if (program.first_slack() == program.variables()) return solve_from(start, warm);
  LoweredWeights weights(program);
  int iterations = 0;
  double seconds = 0.0;
  NlpPoint from = start;
  for (double most = first_weight * size_of_cost(program, start.w);; most *= growth) {
    weights.lower(most);
    const std::vector<int> lowered = program.lowered_slacks();
    if (lowered.empty()) break;
    ScaledResult result = solve_from(from, warm);
    iterations += result.nlp.iterations;
    seconds += result.nlp.seconds;
    if (is_final(result.nlp.status)) {
      weights.restore();
      describe_end(program, iterations, seconds, result.nlp);
      return result;
    }
    if (!is_success(result.nlp.status) || result.is_doubtful) break;
    from = result.nlp.point;
    warm = true;
    if (!is_exact(program, lowered, result.nlp.point)) continue;
    weights.restore();
    complete(program, lowered, result.nlp.point);
    judge(solver, program, quantities, result);
    describe_end(program, iterations, seconds, result.nlp);
    return result;
  }
  weights.restore();
  ScaledResult result = solve_from(from, warm);
  result.nlp.iterations += iterations;
  result.nlp.seconds += seconds;
  return result;
}

}  // namespace saltus
