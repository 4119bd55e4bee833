#include "saltus/solver/solve_in_scale.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include "saltus/solver/infeasibility_proof.hpp"
#include "saltus/solver/scaled_program.hpp"
#include "saltus/solver/scoped_observer.hpp"
#include "saltus/solver/violation_step.hpp"

namespace saltus {
namespace {

// Residuals in the scale of the values of a solution: small enough, and too large for an optimum.
constexpr double small = 1e-8, doubtful = 1e-5;
constexpr double much_larger = 100.0;   // relative to the residual in the scale of the solver
constexpr double accurate = 1e-8;       // relative gain that another scale need not improve
constexpr double most_sharpened = 1e6;  // largest factor of the cost
constexpr int most_sharpenings = 3;     // attempts with a larger cost
constexpr int patience = 100;           // a smaller iteration limit is a deliberate stop

KktCheck::Residual residual_in(NonlinearProgram& program, const ProgramScale& scale,
                               const NlpPoint& point) {
  ScaledProgram in_scale(program, scale);
  return kkt_residual(in_scale, in_scale.to_scaled(point));
}

// Sides that the solver sees: all, or those that may become active (the result is then judged).
enum class Sides { all, without_idle };

ScaledResult solve_once(Solver& solver, NonlinearProgram& program, const ProgramScale& scale,
                        const NlpPoint& start, bool warm, Sides sides = Sides::all) {
  ScaledResult result;
  if (scale.is_one()) {
    result.nlp = solver.solve(program, start, warm);
    result.in_scale = result.nlp.kkt;
    return result;
  }
  ScaledProgram in_scale(program, scale);
  if (sides == Sides::without_idle) in_scale.leave_out_idle_sides();
  {
    const ScopedObserver observed(solver, with_cost_times(solver.observer(), 1.0 / scale.cost));
    result.nlp = solver.solve(in_scale, in_scale.to_scaled(start), warm);
  }
  result.in_scale = result.nlp.kkt;
  result.nlp.point = in_scale.from_scaled(std::move(result.nlp.point));
  if (!program.objective(result.nlp.point.w.data(), result.nlp.objective) &&
      is_success(result.nlp.status))
    result.nlp.status = SolveStatus::evaluation_failed;
  result.nlp.kkt = kkt_residual(program, result.nlp.point);
  return result;
}

ProgramScale as_stated(const NonlinearProgram& program) {
  return {1.0, VectorXd::Ones(program.rows())};
}

bool may_be_mended(SolveStatus status) {
  return status == SolveStatus::infeasible || status == SolveStatus::iteration_limit ||
         status == SolveStatus::numerical_failure || status == SolveStatus::unbounded;
}

void add_effort(const ScaledResult& of, ScaledResult& to) {
  to.nlp.iterations += of.nlp.iterations;
  to.nlp.seconds += of.nlp.seconds;
}

// Largest violation relative to the size of its row or bound.
double relative_violation(NonlinearProgram& program, const VectorXd& w) {
  VectorXd g(program.rows());
  std::vector<double> jacobian(program.jacobian_pattern().entries());
  if (!w.allFinite() || !program.constraints(w.data(), g.data()) ||
      !program.jacobian(w.data(), jacobian.data()) || !g.allFinite())
    return infinity;
  VectorXd size = VectorXd::Ones(program.rows());
  program.jacobian_pattern().for_each(
      [&](int r, int c, int e) { size[r] = std::max(size[r], std::abs(jacobian[e] * w[c])); });
  double worst = 0.0;
  const auto look_at = [&](double value, double lower, double upper, double unit) {
    for (const double side : {lower, upper})
      if (std::isfinite(side)) unit = std::max(unit, std::abs(side));
    worst = std::max(worst, std::max(lower - value, value - upper) / unit);
  };
  for (int r = 0; r < program.rows(); ++r)
    look_at(g[r], program.row_lower()[r], program.row_upper()[r], size[r]);
  for (int i = 0; i < program.variables(); ++i)
    look_at(w[i], program.lower()[i], program.upper()[i], 1.0);
  return worst;
}

bool is_convincing(const ScaledResult& result) {
  return is_success(result.nlp.status) && !result.is_doubtful;
}

// True if the user set a limit that ended the solve early.
bool is_deliberate_stop(const NlpResult& nlp) {
  return nlp.status == SolveStatus::iteration_limit && nlp.iterations < patience;
}

// True if a factor of one scale is more than twice that of the other.
bool differ(const ProgramScale& a, const ProgramScale& b) {
  const auto is_other = [](double x, double y) { return x > 2.0 * y || y > 2.0 * x; };
  if (is_other(a.cost, b.cost)) return true;
  for (int r = 0; r < a.rows.size(); ++r)
    if (is_other(a.rows[r], b.rows[r])) return true;
  const auto unit = [](const ProgramScale& s, int v) {
    return s.variables.size() > 0 ? s.variables[v] : 1.0;
  };
  for (int v = 0; v < std::max(a.variables.size(), b.variables.size()); ++v)
    if (is_other(unit(a, v), unit(b, v))) return true;
  return false;
}

// True if a solver stopped without a limit set by the user and without a verdict on the program.
bool has_given_up(const NlpResult& nlp) {
  return nlp.status == SolveStatus::numerical_failure ||
         (nlp.status == SolveStatus::iteration_limit && !is_deliberate_stop(nlp));
}

// True if a is an optimum and better than b. Of two optima, the cheaper one is better if their
// costs differ by more than their accuracy, as those of two local minima do; otherwise, the more
// accurate one is better.
bool is_better_optimum(const Solver& solver, const ScaledResult& a, const ScaledResult& b) {
  if (!is_convincing(a) || !is_convincing(b)) return is_convincing(a);
  const double difference = a.nlp.objective - b.nlp.objective;
  const double accuracy = a.check.gap + a.check.gain + b.check.gap + b.check.gain;
  if (std::abs(difference) > accuracy)
    return difference < 0.0 && a.violation <= std::max(b.violation, solver.tolerance());
  return a.check.relative_gain() <= b.check.relative_gain();
}

// Moves `next` to `best` if it is better. The one that is kept includes the effort of the other.
// Returns is_better.
bool keep_better(bool is_better, ScaledResult& next, ScaledResult& best) {
  add_effort(is_better ? best : next, is_better ? next : best);
  if (is_better) best = std::move(next);
  return is_better;
}

// Solves cold from the variables w, in the scale of the sizes that the previous attempts revealed.
ScaledResult solve_from(Solver& solver, NonlinearProgram& program, NlpPoint start,
                        const VectorXd& w, const Quantities& quantities, const ProgramSize& size) {
  start.w = w;
  ScaledResult result =
      solve_once(solver, program, size.to_one(), start, false, Sides::without_idle);
  judge(solver, program, quantities, result);
  return result;
}

// Solves again from a result whose cost can still decrease, with the cost multiplied as needed.
// Solver tolerances are absolute and only small relative to a cost of 1. Repeats this while the
// possible decrease shrinks.
void sharpen(Solver& solver, NonlinearProgram& program, const Quantities& quantities,
             ProgramScale scale, ScaledResult& best) {
  for (int round = 0; round < most_sharpenings && best.is_doubtful; ++round) {
    const double gain = best.check.relative_gain(), excess = gain / most_gain(solver);
    if (!is_success(best.nlp.status) || !(excess > 1.0) || !(excess < most_sharpened)) return;
    scale.cost *= std::exp2(std::ceil(std::log2(10.0 * excess)));
    ScaledResult next =
        solve_once(solver, program, scale, best.nlp.point, true, Sides::without_idle);
    judge(solver, program, quantities, next);
    const bool is_closer = is_success(next.nlp.status) && next.check.relative_gain() < gain &&
                           next.violation <= std::max(best.violation, most_violation);
    if (!keep_better(is_convincing(next) || is_closer, next, best)) return;
  }
}

// True if the solver failed without a limit set by the user, at a point that violates the rows.
bool has_missed_rows(NonlinearProgram& program, const NlpResult& nlp) {
  if (!may_be_mended(nlp.status) || nlp.contradiction || nlp.is_proved_infeasible) return false;
  if (is_deliberate_stop(nlp)) return false;
  return nlp.status == SolveStatus::infeasible ||
         relative_violation(program, nlp.point.w) > most_violation;
}

// Sets the status to infeasible if multipliers prove it where the solver did not decide.
void prove_infeasible(NonlinearProgram& program, ScaledResult& best) {
  NlpResult& nlp = best.nlp;
  if (!has_missed_rows(program, nlp) || !is_proved_infeasible(program, nlp.point.w)) return;
  nlp.status = SolveStatus::infeasible;
  nlp.is_proved_infeasible = true;
}

// Solves again after a failure away from the rows, from the end of a step towards them, divided by
// the sizes there. Accepts "infeasible" only if such a step, in variables of any unit, does not
// help.
void begin_nearer_to_rows(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                          const Quantities& quantities, ProgramSize& size, ScaledResult& best) {
  if (!has_missed_rows(program, best.nlp)) return;
  const bool is_infeasible = best.nlp.status == SolveStatus::infeasible;
  const std::optional<VectorXd> nearer = step_towards_rows(program, best.nlp.point.w);
  if (!nearer || !size.look_at(*nearer)) return;
  ScaledResult next = solve_from(solver, program, start, *nearer, quantities, size);
  if (!is_infeasible && !is_convincing(next)) {
    add_effort(next, best);
    return;
  }
  add_effort(best, next);
  // The solver reports infeasible again although a better point exists.
  if (next.nlp.status == SolveStatus::infeasible && !next.nlp.contradiction &&
      step_towards_rows(program, next.nlp.point.w))
    next.nlp.status = SolveStatus::numerical_failure;
  best = std::move(next);
}

// Largest first and second derivative of the cost at a point, penalties included.
double size_of_cost(NonlinearProgram& program, const VectorXd& w) {
  VectorXd gradient(program.variables());
  const VectorXd lambda = VectorXd::Zero(program.rows());
  std::vector<double> curvature(program.hessian_pattern().entries());
  if (!program.gradient(w.data(), gradient.data()) || !gradient.allFinite()) return 1.0;
  double size = gradient.cwiseAbs().maxCoeff();
  if (program.supports(Curvature::exact) &&
      program.hessian(w.data(), 1.0, lambda.data(), curvature.data(), Curvature::exact)) {
    for (const double entry : curvature) size = std::max(size, std::abs(entry));
  }
  return std::isfinite(size) ? size : 1.0;
}

// Solves again after a breakdown if the cost has huge coefficients, with the cost divided by the
// largest one. A penalty weight is not a magnitude, but it can hide the rows from a linear system.
void begin_with_small_cost(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                           bool warm, const Quantities& quantities, ProgramScale scale,
                           ScaledResult& best) {
  constexpr double huge = 1e6;
  if (!has_given_up(best.nlp)) return;
  ScaledProgram in_scale(program, scale);
  const double size = size_of_cost(in_scale, in_scale.to_scaled(start).w);
  if (!(size > huge)) return;
  scale.cost /= size;
  ScaledResult next = solve_once(solver, program, scale, start, warm, Sides::without_idle);
  judge(solver, program, quantities, next);
  keep_better(is_convincing(next), next, best);
}

// True if the solver broke down, without a limit set by the user, at a point that satisfies the
// rows.
bool has_broken_down(NonlinearProgram& program, const NlpResult& nlp) {
  const bool has_failed = nlp.status == SolveStatus::numerical_failure ||
                          nlp.status == SolveStatus::evaluation_failed ||
                          nlp.status == SolveStatus::iteration_limit;
  return has_failed && !is_deliberate_stop(nlp) &&
         relative_violation(program, nlp.point.w) <= most_violation;
}

// Solves again from such a point if the values there show that the program was badly scaled,
// divided by the sizes there.
void begin_at_rows(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                   const Quantities& quantities, ProgramSize& size, const ProgramScale& scale,
                   ScaledResult& best) {
  if (!has_broken_down(program, best.nlp) || !size.look_at(best.nlp.point.w)) return;
  if (size.is_well_scaled_where_known(scale) && !size.is_badly_scaled(scale)) return;
  ScaledResult next = solve_from(solver, program, start, best.nlp.point.w, quantities, size);
  keep_better(is_convincing(next), next, best);
}

}  // namespace

void judge(const Solver& solver, NonlinearProgram& program, const Quantities& quantities,
           ScaledResult& result) {
  const NlpResult& nlp = result.nlp;
  if (nlp.point.w.size() != program.variables()) return;
  const bool gave_up =
      nlp.status == SolveStatus::numerical_failure || nlp.status == SolveStatus::unbounded;
  if (!is_success(nlp.status) && !gave_up) return;
  result.check = check_optimum(program, nlp.point, quantities);
  result.violation = relative_violation(program, nlp.point.w);
  const bool is_optimum = result.check.relative_gain() <= most_gain(solver) &&
                          result.violation <= std::max(most_violation, solver.tolerance());
  // The point is an optimum if the solver failed with short steps, or if it met the tolerance in
  // the units of the program but not in its own scale.
  const bool has_stalled =
      nlp.status == SolveStatus::numerical_failure || nlp.status == SolveStatus::acceptable;
  if (is_optimum && has_stalled && nlp.kkt.scaled() <= solver.tolerance())
    result.nlp.status = SolveStatus::optimal;
  result.is_doubtful = is_success(nlp.status) && !is_optimum;
}

double most_gain(const Solver& solver) { return std::max(1e-5, 100.0 * solver.tolerance()); }

ScaledResult solve_in_scale(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                            bool warm, const Quantities& quantities) {
  ProgramSize size(program, quantities);
  if (!size.look_at(start.w)) return solve_as_stated(solver, program, start, warm, quantities);
  ProgramScale scale = size.usual();
  const ProgramScale of_start = size.to_one();  // gives the same program in any units
  ScaledResult best = solve_once(solver, program, scale, start, warm);
  judge(solver, program, quantities, best);
  ProgramScale of_best = scale;
  for (int attempt = 0; attempt < 2; ++attempt) {
    const bool is_solved = is_success(best.nlp.status), was_convincing = is_convincing(best);
    if (was_convincing && best.check.relative_gain() <= accurate) break;
    if (is_solved && !size.look_at(best.nlp.point.w)) break;
    const bool is_usual = size.is_well_scaled_where_known(scale);
    // In a good scale, only the tolerance was too large.
    if (is_usual && is_solved) {
      if (!was_convincing) sharpen(solver, program, quantities, scale, best);
      if (is_convincing(best)) break;
    }
    const ProgramScale next_scale = size.to_one();
    const bool is_bad = !is_usual || size.is_badly_scaled(scale) ||
                        ScaledProgram(program, next_scale).leave_out_idle_sides() > 0;
    if (!is_solved && !(is_bad ? may_be_mended(best.nlp.status)
                               : has_given_up(best.nlp) && differ(scale, next_scale)))
      break;
    scale = next_scale;
    // Continues from a successful result, otherwise restarts.
    ScaledResult next = solve_once(solver, program, scale, is_solved ? best.nlp.point : start,
                                   is_solved || warm, Sides::without_idle);
    judge(solver, program, quantities, next);
    const auto begin_anew = [&](const ProgramScale& in) {
      ScaledResult anew = solve_once(solver, program, in, start, warm, Sides::without_idle);
      judge(solver, program, quantities, anew);
      keep_better(is_better_optimum(solver, anew, next), anew, next);
    };
    if (is_solved && !was_convincing && !is_convincing(next)) begin_anew(scale);
    if (is_solved && attempt == 0 && size.is_well_scaled_where_known(of_start)) {
      begin_anew(of_start);
    }
    const bool is_better =
        is_solved ? is_better_optimum(solver, next, best) : is_bad || is_success(next.nlp.status);
    if (!keep_better(is_better, next, best)) break;
    of_best = scale;
  }
  begin_with_small_cost(solver, program, start, warm, quantities, of_best, best);
  if (best.is_doubtful) sharpen(solver, program, quantities, of_best, best);
  begin_at_rows(solver, program, start, quantities, size, of_best, best);
  prove_infeasible(program, best);
  begin_nearer_to_rows(solver, program, start, quantities, size, best);
  return best;
}

ScaledResult solve_as_stated(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                             bool warm, const Quantities& quantities) {
  ScaledResult result = solve_once(solver, program, as_stated(program), start, warm);
  judge(solver, program, quantities, result);
  return result;
}

ScaledResult solve_scaled_tick(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                               bool warm, const Quantities& quantities) {
  ProgramSize size(program, quantities);
  if (!size.look_at(start.w)) return solve_once(solver, program, as_stated(program), start, warm);
  ProgramScale scale = size.usual();
  ScaledResult result = solve_once(solver, program, scale, start, warm);
  for (const bool is_last : {false, false, true}) {
    const bool is_solved = is_success(result.nlp.status);
    if (is_solved) {
      const double in_solver = result.in_scale.scaled();
      if (!size.look_at(result.nlp.point.w) || size.is_well_scaled_where_known(scale))
        return result;
      result.in_scale = residual_in(program, size.to_one(), result.nlp.point);
      result.is_doubtful = result.in_scale.scaled() > std::max(doubtful, much_larger * in_solver);
      if (result.in_scale.scaled() <= std::max(small, much_larger * in_solver)) return result;
    } else if (!may_be_mended(result.nlp.status) || !size.is_badly_scaled(scale)) {
      return result;
    }
    if (is_last) return result;
    scale = size.to_one();
    ScaledResult again = solve_once(solver, program, scale, start, warm);
    if (is_solved && !is_success(again.nlp.status)) {
      add_effort(again, result);
      return result;
    }
    add_effort(result, again);
    result = std::move(again);
  }
  return result;
}

}  // namespace saltus
