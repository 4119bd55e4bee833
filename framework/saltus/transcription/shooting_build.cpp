// Set-up of ShootingProgram: variables, rows and blocks for every grid point at which a term may be
// active.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/ocp/cost_functions.hpp"
#include "saltus/ocp/interval_problem_of.hpp"
#include "saltus/transcription/interval_function.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

using namespace shooting;

namespace {

// Indices of terms that are summed or integrated along the phase.
std::vector<int> running_costs(const PhaseDefinition& phase) {
  std::vector<int> result;
  for (int t = 0; t < static_cast<int>(phase.terms.size()); ++t)
    if (phase.terms[t].kind != Term::Kind::constraint &&
        phase.terms[t].domain == Term::Domain::running)
      result.push_back(t);
  return result;
}

}  // namespace

ShootingProgram::ShootingProgram(OptimalControlProblem problem, const std::vector<Mesh>& meshes,
                                 const IntegratorChoice& integrator, int threads)
    : problem_(std::move(problem)),
      data_(problem_),
      grid_(problem_, meshes),
      layout_(problem_, grid_, *this),
      proposal_{grid_, {}, {}} {
  set_threads(threads);
  build_start();
  for (int j = 0; j < grid_.phases(); ++j) {
    if (j > 0) jump_rows_.push_back(build_jump(problem_.jumps()[j], j - 1, j));
    build_integral_start(j);
    build_phase(j, integrator);
  }
  if (problem_.closing()) closing_row_ = build_jump(*problem_.closing(), grid_.phases() - 1, 0);
  build_total_time();
  for (int j = 0; j < grid_.phases(); ++j) build_integral_limits(j);
  for (std::size_t l = 0; l < problem_.links().size(); ++l) build_link(static_cast<int>(l));
  build_slacks();
  finish();
  place_data();
  proposal_.lower = lower().head(first_slack_);
  proposal_.upper = upper().head(first_slack_);
  propose(data_);
  refresh();
}

int ShootingProgram::new_rows(int count, const std::string& what) {
  const int first = add_rows(count);
  if (count > 0) row_groups_.push_back({first, what, {}, false});
  return first;
}

void ShootingProgram::build_start() {
  const PhaseDefinition& first = problem_.phases().front();
  start_row_ = new_rows(first.sizes.nx, "start of the problem, state");
  for (int i = 0; i < first.sizes.nx; ++i) add_linear(start_row_ + i, layout_.state(0, 0) + i, 1.0);
}

void ShootingProgram::build_phase(int j, const IntegratorChoice& choice) {
  const PhaseDefinition& phase = problem_.phases()[j];
  const bool integrated = problem_.cost_rule(j) == CostRule::integrated;
  std::vector<Function> running;
  std::vector<int> optional;  // costs that are active in windows only
  if (integrated)
    for (const int t : running_costs(phase)) {
      if (!phase.terms[t].window.is_whole()) optional.push_back(static_cast<int>(running.size()));
      running.push_back(cost_function(phase.terms[t]));
    }
  const bool costs_ride_along = !running.empty();
  for (const IntegralConstraint& integral : phase.integrals) running.push_back(integral.integrand);

  IntervalProblem interval = interval_problem_of(phase);
  SelectiveStack& costs = integrated_costs_.emplace_back();
  if (!running.empty()) {
    costs = SelectiveStack(std::move(running));
    interval.running_cost = costs.function();
  }
  interval.shape = phase.input_shape();
  for (int i = 0; i < phase.sizes.np; ++i)
    interval.differentiate_parameter[i] = layout_.parameter(j, i) >= 0;
  interval.differentiate_time = layout_.start_time() >= 0;
  for (int i = 0; i <= j; ++i)
    interval.differentiate_time = interval.differentiate_time || layout_.duration(i) >= 0;
  try {
    integrators_.push_back(choice->make(interval));
  } catch (const DefinitionError& e) {
    throw DefinitionError(fmt::format("phase '{}': {}", phase.name, e.what()));
  }
  // Any thread may evaluate a plan's states, so its integrator must not use costs of the program.
  IntervalProblem states = interval;
  states.running_cost = {};
  for (SwitchingSystem::Mode& mode : states.switching.modes) mode.running_cost = {};
  reentrant_integrators_.push_back(std::make_shared<const ReentrantIntegrator>(states, choice));
  if (!integrators_.back()->has_hessian()) {
    set_support(false, supports(Curvature::gauss_newton) && !costs_ride_along);
  }

  if (!integrators_.back()->follows_running_costs()) optional.clear();
  build_intervals(j, interval_function(integrators_.back(), choice, costs, optional), interval.nq(),
                  optional);
  for (int t = 0; t < static_cast<int>(phase.terms.size()); ++t) {
    const Term& term = phase.terms[t];
    if (term.domain == Term::Domain::running) {
      build_running(j, t, integrated);
      continue;
    }
    const GridPoint point{
        .phase = j, .node = term.domain == Term::Domain::phase_start ? 0 : grid_.intervals(j)};
    if (term.kind == Term::Kind::constraint) {
      add_row_instance(j, t, point, true);
    } else {
      const BlockInstance b = add_term_block(cost_function(term), point, {BlockOutput{}}, false);
      costs_.push_back({j, t, -1, b.block, 0, false});
    }
  }
  if (phase.input_change_weight.size() > 0) build_changes(j);
}

void ShootingProgram::build_intervals(int j, const Function& flow, int nq,
                                      const std::vector<int>& optional) {
  const PhaseDefinition& phase = problem_.phases()[j];
  const Arguments& sizes = phase.sizes;
  const IntervalArguments a = integrators_[j]->arguments();
  const std::vector<int> running = running_costs(phase);
  const int ni = static_cast<int>(phase.integrals.size());

  for (int k = 0; k < grid_.intervals(j); ++k) {
    const GridPoint point{j, k, k, false};
    IntervalInstance instance{
        j, k,
        new_rows(sizes.nx, fmt::format("phase '{}', end of interval {}, state", phase.name, k)),
        -1};
    Block block(flow);
    for (int i = 0; i < sizes.nx; ++i)
      block.coefficients[a.x(i)] = {{layout_.state(j, k) + i, phase.nominal_state[i]}};
    for (int i = 0; i < a.nc; ++i)
      block.coefficients[a.c(i)] = {{layout_.input(j, k) + i, phase.nominal_input[i % sizes.nu]}};
    for (int i = 0; i < sizes.np; ++i)
      if (layout_.parameter(j, i) >= 0)
        block.coefficients[a.p(i)] = {{layout_.parameter(j, i), phase.nominal_parameter(i)}};
    block.coefficients[a.t0()] = time_coefficients(point);
    block.coefficients[a.h()] = offset_coefficients(j, grid_.interval(j, k).length1);
    // Defect: x_(k+1) - x(t_k + h) = 0, divided by the nominal state.
    for (int i = 0; i < sizes.nx; ++i) {
      bound_row(instance.first_row + i, 0.0, 0.0);
      block.outputs.push_back({instance.first_row + i, -1.0 / phase.nominal_state[i]});
      add_linear(instance.first_row + i, layout_.state(j, k + 1) + i, 1.0);
    }
    for (int q = 0; q < nq - ni; ++q) block.outputs.push_back({});
    if (ni > 0)
      instance.integral_row =
          new_rows(ni, fmt::format("phase '{}', end of interval {}, integral", phase.name, k));
    for (int i = 0; i < ni; ++i) {  // q_(k+1) - q_k - integral = 0, divided by the magnitude
      const int row = instance.integral_row + i;
      bound_row(row, 0.0, 0.0);
      block.outputs.push_back({row, -1.0 / phase.integrals[i].magnitude});
      add_linear(row, layout_.integral(j, k + 1) + i, 1.0);
      add_linear(row, layout_.integral(j, k) + i, -1.0);
    }
    const int index = instance.block = add_block(std::move(block));
    placed_.push_back({index, point, a.t0(), a.h(), a.p()});
    for (int q = 0; q < nq - ni; ++q) {
      const auto at = std::find(optional.begin(), optional.end(), q);
      const int argument = a.size() + static_cast<int>(at - optional.begin());
      costs_.push_back(
          {j, running[q], k, index, sizes.nx + q, true, at == optional.end() ? -1 : argument});
    }

    join_inputs(j, k, instance);
    intervals_.push_back(instance);
  }
}

// Continuous inputs: the end of a ramp equals the start of the next. Held inputs: the same
// constant, and for ramps the same slope.
void ShootingProgram::join_inputs(int j, int k, IntervalInstance& instance) {
  const PhaseDefinition& phase = problem_.phases()[j];
  const int nu = phase.sizes.nu;
  const bool is_linear = phase.input_shape() == InputShape::linear;
  const bool holds = grid_.has_held_inputs(j);
  const bool is_continuous =
      phase.input_parametrisation == InputParametrisation::piecewise_linear_continuous;
  if ((!holds && !is_continuous) || k + 1 >= grid_.intervals(j)) return;
  instance.continuity_row =
      new_rows(nu, fmt::format("phase '{}', continuity at node {}, input", phase.name, k + 1));
  const int far_end = is_linear ? nu : 0;
  for (int i = 0; i < nu; ++i) {
    add_linear(instance.continuity_row + i, layout_.input(j, k) + far_end + i, 1.0);
    add_linear(instance.continuity_row + i, layout_.input(j, k + 1) + i, -1.0);
  }
  if (!holds || !is_linear) return;
  instance.slope_row =
      new_rows(nu, fmt::format("phase '{}', slope at node {}, input", phase.name, k + 1));
  for (int i = 0; i < nu; ++i) {  // with the continuity rows: equal c1 - c0
    add_linear(instance.slope_row + i, layout_.input(j, k) + i, 1.0);
    add_linear(instance.slope_row + i, layout_.input(j, k + 1) + i, -2.0);
    add_linear(instance.slope_row + i, layout_.input(j, k + 1) + nu + i, 1.0);
  }
}

// x+ - g(t, x-, p) = 0, divided by the nominal state of the next phase.
int ShootingProgram::build_jump(const Jump& jump, int ends, int begins) {
  const PhaseDefinition& from = problem_.phases()[ends];
  const PhaseDefinition& to = problem_.phases()[begins];
  const int end = grid_.intervals(ends);
  const bool closes = begins <= ends;
  const int first_row = new_rows(
      to.sizes.nx, closes ? fmt::format("closing '{}' from the end of phase '{}' to the start of "
                                        "phase '{}', state",
                                        jump.name, from.name, to.name)
                          : fmt::format("jump '{}' from phase '{}' to phase '{}', state", jump.name,
                                        from.name, to.name));
  for (int i = 0; i < to.sizes.nx; ++i) {
    bound_row(first_row + i, 0.0, 0.0);
    add_linear(first_row + i, layout_.state(begins, 0) + i, 1.0);
  }
  if (!jump.map) {
    for (int i = 0; i < to.sizes.nx; ++i)
      add_linear(first_row + i, layout_.state(ends, end) + i,
                 -from.nominal_state[i] / to.nominal_state[i]);
    return first_row;
  }
  const int n = jump.map.inputs();
  const int first_parameter = 1 + from.sizes.nx;
  const GridPoint point{.phase = ends, .node = end};
  Block block(jump.map);
  block.coefficients[0] = time_coefficients(point);
  for (int i = 0; i < from.sizes.nx; ++i)
    block.coefficients[1 + i] = {{layout_.state(ends, end) + i, from.nominal_state[i]}};
  for (int i = 0; first_parameter + i < n; ++i)
    if (layout_.parameter(ends, i) >= 0)
      block.coefficients[first_parameter + i] = {
          {layout_.parameter(ends, i), from.nominal_parameter(i)}};
  for (int i = 0; i < to.sizes.nx; ++i)
    block.outputs.push_back({first_row + i, -1.0 / to.nominal_state[i]});
  BlockInstance placed{add_block(std::move(block)), point, 0, -1, first_parameter};
  if (n == first_parameter) placed.parameter_argument = -1;
  placed_.push_back(placed);
  return first_row;
}

void ShootingProgram::build_total_time() {
  const std::vector<VariableCoefficient> coefficients = duration_coefficients(grid_.phases());
  if (coefficients.empty() || problem_.total_time().is_free()) return;
  total_time_row_ = new_rows(1, "total time, row");
  for (const VariableCoefficient& s : coefficients)
    add_linear(total_time_row_, s.variable, s.factor);
}

std::string ShootingProgram::describe_row(int row, const VectorXd* w) const {
  const auto after = std::upper_bound(row_groups_.begin(), row_groups_.end(), row,
                                      [](int r, const RowGroup& group) { return r < group.first; });
  const RowGroup& group = *(after - 1);
  std::string text = fmt::format("{} {}", group.name, row - group.first);
  if (group.has_point) text += fmt::format(" at t = {:.6g} s", time_of(group.point, w));
  return text;
}

}  // namespace saltus
