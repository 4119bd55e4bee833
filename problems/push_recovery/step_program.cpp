#include "problems/push_recovery/step_program.hpp"

#include <algorithm>
#include <utility>
#include <vector>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus::push_recovery {
namespace {

// A plan has converged if it changes by less than this between two quadratic programs: 0.1 mm, 0.1
// ms and similar in the scaled variables, far below the accuracy of a foot or a landing.
constexpr double converged = 1e-3;
constexpr double feasible = 1e-2;  // 1 mm

}  // namespace

ShootingOptions step_grid(const OptimalControlProblem& problem) {
  // Single supports last about 2 / omega, double supports a fraction of it.
  constexpr int long_intervals = 4, short_intervals = 1;
  ShootingOptions options;
  options.integrator = runge_kutta4();
  for (const PhaseDefinition& phase : problem.phases()) {
    const bool is_long = phase.name.starts_with("single") || phase.name == "standing";
    options.intervals.push_back(is_long ? long_intervals : short_intervals);
  }
  return options;
}

namespace {

std::unique_ptr<MultipleShooting> transcribed(OptimalControlProblem problem) {
  ShootingOptions options = step_grid(problem);
  return std::make_unique<MultipleShooting>(std::move(problem), std::move(options));
}

}  // namespace

StepProgram::StepProgram(const StepModel& model, int steps, bool from_two_feet)
    : steps_(steps),
      from_two_feet_(from_two_feet),
      model_(model),
      shooting_(transcribed(step_problem(model, steps, from_two_feet))),
      solver_(
          make_real_time_iteration(shooting_->nlp(), {.tolerance = 1e-6, .max_iterations = 40})),
      check_(shooting_->nlp()) {
  const NonlinearProgram& nlp = shooting_->nlp();
  initial_ = shooting_->initial_guess();
  initial_.lambda = VectorXd::Zero(nlp.rows());
  initial_.z = VectorXd::Zero(nlp.variables());
  plan_ = before_ = initial_;
  solution_.steps = steps;
  solution_.place.fill(Vec<double, 2>::Zero());
}

void StepProgram::begin_at(double elapsed, Bounds first) {
  const NonlinearProgram& nlp = shooting_->nlp();
  if (!has_plan_) {
    plan_ = initial_;
    has_multipliers_ = false;
  }
  const int duration = shooting_->layout().duration(0);
  if (duration >= 0) {
    const double nominal = shooting_->problem().phases()[0].nominal_duration;
    if (has_plan_) plan_.w[duration] -= elapsed / nominal;
    shooting_->set_remaining(first, unbounded());
  }
  plan_.w = plan_.w.cwiseMax(nlp.lower()).cwiseMin(nlp.upper());
}

const StepSolution& StepProgram::solve(const StepNow<double>& now,
                                       const Vec<double, step_states>& state, Bounds first,
                                       double elapsed, int most_iterations) noexcept {
  solution_.is_solved = false;
  solution_.cost = solution_.missed = solution_.residual = infinity;
  solution_.iterations = 0;
  if (!state.allFinite() || !packed(now).allFinite()) return solution_;
  try {
    NonlinearProgram& nlp = shooting_->nlp();
    shooting_->set_data("now", now);
    now_ = now;
    state_ = state;
    shooting_->start_at(0.0, state);
    begin_at(elapsed, first);
    while (solution_.iterations < most_iterations) {
      before_.w = plan_.w;
      solver_->prepare(nlp, plan_);
      const RealTimeSolver::Result r =
          solver_->feedback(nlp, plan_, has_multipliers_, WallClock::time_point::max());
      ++solution_.iterations;
      if (!plan_.w.allFinite() || !plan_.lambda.allFinite() || !plan_.z.allFinite() ||
          !(is_success(r.status) || r.status == SolveStatus::step_taken)) {
        has_plan_ = false;
        return solution_;
      }
      plan_.w = plan_.w.cwiseMax(nlp.lower()).cwiseMin(nlp.upper());
      has_plan_ = has_multipliers_ = true;
      if ((plan_.w - before_.w).lpNorm<Eigen::Infinity>() < converged) break;
    }
    read_solution();
  } catch (...) {  // contradictory data: no plan in this tick
    has_plan_ = false;
  }
  return solution_;
}

void StepProgram::read_solution() {
  NonlinearProgram& nlp = shooting_->nlp();
  const ShootingProgram& program = shooting_->program();
  const Layout& layout = shooting_->layout();
  solution_.residual = check_(nlp, plan_).feasibility;
  if (!nlp.objective(plan_.w.data(), solution_.cost)) solution_.cost = infinity;
  const int phases = shooting_->grid().phases();
  double paid = 0.0;
  for (const shooting::RowInstance& row : program.row_instances())
    for (const auto* slacks : {&row.slack_below, &row.slack_above})
      for (const int slack : *slacks)
        if (slack >= 0) paid += std::max(0.0, plan_.w[slack]);
  solution_.missed = paid;
  double time = 0.0;
  int step = 0;
  for (int j = 0; j < phases && steps_ > 0; ++j) {
    const bool is_swing = (j % 2 == 0) != from_two_feet_;
    const PhaseDefinition& phase = shooting_->problem().phases()[j];
    if (is_swing) solution_.lift_off[step] = time;
    time += plan_.w[layout.duration(j)] * phase.nominal_duration;
    if (!is_swing) continue;
    solution_.landing[step] = time;
    for (int i = 0; i < 2; ++i) {
      const int entry = size_of<StepNow> + 2 * step + i;
      solution_.place[step][i] =
          plan_.w[layout.parameter(j, entry)] * phase.nominal_parameter(entry);
    }
    ++step;
  }
  const double* u = plan_.w.data() + layout.input(0, 0);
  solution_.pressure = in_hull<double>(sole(0), sole(-1), u[4], Vec<double, 2>(u[0], u[1]));
  solution_.lent_rate = model_.lent_rate * Vec<double, 2>(u[2], u[3]);
  solution_.is_solved = std::isfinite(solution_.cost) && solution_.residual < feasible;
}

// Supported part of the k-th foot, as in step_problem().
SupportedSole<double> StepProgram::sole(int k) const {
  const Vec<double, 2>& half = steps_ > 0 ? model_.sole : model_.standing_sole;
  if (k > 0) return {solution_.place[k - 1], half};
  return k < 0 ? supported<double>(now_.other, now_.other_support, half)
               : supported<double>(Vec<double, 2>::Zero(), now_.stance_support, half);
}

// Planned centre of pressure; after the plan, its last value.
Vec<double, 2> StepProgram::pressure_at(double time) const {
  const Layout& layout = shooting_->layout();
  const Grid& grid = shooting_->grid();
  int j = 0;
  double begin = 0.0, length = model_.standing;
  for (;; ++j) {
    const int duration = layout.duration(j);
    if (duration >= 0)
      length = plan_.w[duration] * shooting_->problem().phases()[j].nominal_duration;
    if (time < begin + length || j + 1 >= grid.phases()) break;
    begin += length;
  }
  const int intervals = grid.intervals(j);
  const int interval =
      std::clamp(static_cast<int>(intervals * (time - begin) / length), 0, intervals - 1);
  const double* u = plan_.w.data() + layout.input(j, interval);
  // Phases: unloading on feet 0 and -1 (optional), then alternating single and double support.
  const int later = j - (from_two_feet_ ? 1 : 0);
  const bool is_first = steps_ == 0 || later < 0, is_single = !is_first && later % 2 == 0;
  const int before = is_first ? 0 : later / 2, after = is_first    ? -1
                                                       : is_single ? before
                                                                   : before + 1;
  return in_hull<double>(sole(before), sole(after), is_single ? 0.0 : u[4],
                         Vec<double, 2>(u[0], u[1]));
}

void StepProgram::sample(walking::StepPlan::Motion& motion) const {
  constexpr int pieces = 4;
  constexpr double h = walking::StepPlan::Motion::step / pieces;
  Vec<double, 2> com = state_.head<2>(), capture = state_.segment<2>(2);
  const Vec<double, 2> lent = state_.segment<2>(4);  // nearly constant meanwhile
  const double omega = now_.omega;
  motion.samples = walking::StepPlan::Motion::most_samples;
  for (int i = 0; i < motion.samples; ++i) {
    motion.com[i] = com;
    motion.capture_point[i] = capture;
    for (int k = 0; k < pieces; ++k) {  // midpoint rule
      const Vec<double, 2> cop = pressure_at((i * pieces + k + 0.5) * h);
      const Vec<double, 2> half_com = com + 0.5 * h * omega * (capture + lent - com),
                           half = capture + 0.5 * h * omega * (capture + lent - cop);
      com += h * omega * (half + lent - half_com);
      capture += h * omega * (half + lent - cop);
    }
  }
}

Solution StepProgram::report() {
  NlpResult result;
  result.status = SolveStatus::feasible;
  result.point = plan_;
  shooting_->nlp().objective(result.point.w.data(), result.objective);
  result.kkt = check_(shooting_->nlp(), result.point);
  return shooting_->interpret(std::move(result));
}

}  // namespace saltus::push_recovery
