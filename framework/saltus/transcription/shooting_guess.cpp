// Initial guess as a point of the program, from the guesses of the problem or another solution.
#include <fmt/format.h>

#include <algorithm>

#include "saltus/core/error.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {
namespace {

// Value of a guess. PhaseDefinition::check() has evaluated it at the ends of the phase only.
VectorXd value_of(const PhaseDefinition& phase, const char* what, const Guess& guess, int size,
                  double fraction) {
  VectorXd value = guess.at(fraction);
  if (value.size() != size)
    throw DefinitionError(
        fmt::format("phase '{}': the guess of the {} has {} entries at the fraction {:.4g} of the "
                    "phase, expected {}",
                    phase.name, what, value.size(), fraction, size));
  if (!value.allFinite())
    throw DefinitionError(
        fmt::format("phase '{}': the guess of the {} is not finite at the fraction {:.4g} of the "
                    "phase",
                    phase.name, what, fraction));
  return value;
}

// A trajectory of another problem is not a guess. Phases may be missing or have other numbers.
void check_guess(const OptimalControlProblem& problem, const Trajectory& guess) {
  if (guess.empty())
    throw DefinitionError(fmt::format(
        "problem '{}': the guess is an empty trajectory, like that of a solve without a "
        "plan; leave it out to use the guesses of the phases",
        problem.name()));
  for (const Trajectory::Piece& piece : guess.pieces()) {
    const Trajectory::PhaseInfo& info = guess.phases()[piece.phase];
    for (const PhaseDefinition& phase : problem.phases()) {
      if (phase.name != info.name) continue;
      const auto check_size = [&](const char* what, Eigen::Index given, int expected) {
        if (given != expected)
          throw DefinitionError(fmt::format(
              "problem '{}': the guess has {} {} in phase '{}', expected {}: use a trajectory of "
              "this problem",
              problem.name(), given, what, phase.name, expected));
      };
      check_size("states", piece.state.size(), phase.sizes.nx);
      check_size("parameters", info.parameters.size(), phase.sizes.np);
      const int inputs = info.integrator->problem().arguments.nu;
      check_size("inputs", inputs, phase.sizes.nu);
    }
  }
}

}  // namespace

NlpPoint MultipleShooting::initial_guess() const {
  NlpPoint point{VectorXd::Zero(checked().variables()), {}, {}};
  VectorXd& w = point.w;
  VectorXd start = problem().start_guess();
  for (int i = 0; i < start.size(); ++i)
    start[i] = std::clamp(start[i], data().start_bounds[i].lower, data().start_bounds[i].upper);
  for (int j = 0; j < grid().phases(); ++j) {
    const PhaseDefinition& phase = problem().phases()[j];
    const int nx = phase.sizes.nx, nu = phase.sizes.nu;
    const double T = grid().reference_duration(j);
    const VectorXd p = program_->parameters_of(j, nullptr);
    for (int i = 0; i < p.size(); ++i)
      if (layout().parameter(j, i) >= 0)
        w[layout().parameter(j, i)] = p[i] / phase.nominal_parameter(i);
    if (layout().duration(j) >= 0) w[layout().duration(j)] = T / phase.nominal_duration;

    const auto fraction = [&](int node) { return T > 0.0 ? grid().node_offset(j, node) / T : 0.0; };
    const auto input = [&](int k, double at) {
      VectorXd u = phase.input_guess.is_given()
                       ? value_of(phase, "input", phase.input_guess, nu, at)
                       : VectorXd::Zero(nu);
      for (int i = 0; i < nu; ++i) {
        const Bounds b = program_->input_bounds(j, k, i);
        u[i] = std::clamp(u[i], b.lower, b.upper);
      }
      return u;
    };
    const auto set_state = [&](int node, const VectorXd& x) {
      w.segment(layout().state(j, node), nx) = x.cwiseQuotient(phase.nominal_state);
    };

    VectorXd x =
        phase.state_guess.is_given() ? value_of(phase, "state", phase.state_guess, nx, 0.0) : start;
    Integrator& integrator = *program_->integrators()[j];
    const IntervalArguments a = integrator.arguments();
    VectorXd argument(a.size()), end(integrator.outputs());
    set_state(0, x);
    for (int k = 0; k < grid().intervals(j); ++k) {
      VectorXd c(a.nc);
      c.head(nu) = input(k, fraction(k));
      if (phase.input_shape() == InputShape::linear) c.tail(nu) = input(k, fraction(k + 1));
      for (int i = 0; i < a.nc; ++i)
        w[layout().input(j, k) + i] = c[i] / phase.nominal_input[i % nu];
      if (phase.state_guess.is_simulated()) {
        argument << x, c, p, program_->start_of(j, nullptr) + grid().node_offset(j, k),
            grid().node_offset(j, k + 1) - grid().node_offset(j, k);
        if (integrator.value(argument.data(), end.data()) == IntegrationStatus::success)
          x = end.head(nx);
      } else if (phase.state_guess.is_given()) {
        x = value_of(phase, "state", phase.state_guess, nx, fraction(k + 1));
      }
      set_state(k + 1, x);
    }
    if (j + 1 == grid().phases()) break;
    start = problem().jumps()[j + 1].apply(program_->start_of(j + 1, nullptr), x, p);
  }
  if (layout().start_time() >= 0) w[layout().start_time()] = data().start_time;
  program_->fill_integrals(w);
  return point;
}

NlpPoint MultipleShooting::guess_from(const Trajectory& trajectory) const {
  NlpPoint point = initial_guess();
  check_guess(problem(), trajectory);
  bool is_used = false;
  double start = data().start_time;
  if (layout().start_time() >= 0)
    start = point.w[layout().start_time()] =
        std::clamp(trajectory.start_time(), problem().start_time_bounds()->lower,
                   problem().start_time_bounds()->upper);
  for (int j = 0; j < grid().phases(); ++j) {
    const PhaseDefinition& phase = problem().phases()[j];
    const int nx = phase.sizes.nx, nu = phase.sizes.nu;
    double T = grid().reference_duration(j);
    if (layout().duration(j) >= 0) {  // keeps its end time
      for (const Trajectory::Piece& piece : trajectory.pieces())
        if (piece.phase == j)
          T = std::clamp(piece.end() - start, data().duration_bounds[j].lower,
                         data().duration_bounds[j].upper);
      point.w[layout().duration(j)] = T / phase.nominal_duration;
    }
    if (j < static_cast<int>(trajectory.phases().size()) &&
        trajectory.phases()[j].parameters.size() == phase.sizes.np)
      for (int i = 0; i < phase.sizes.np; ++i)
        if (layout().parameter(j, i) >= 0)
          point.w[layout().parameter(j, i)] =
              trajectory.phases()[j].parameters[i] / phase.nominal_parameter(i);
    const auto time_of = [&](int node) {
      return node == grid().intervals(j) ? start + T : start + grid().interval(j, node).offset(T);
    };
    for (int k = 0; k <= grid().intervals(j); ++k) {
      const double t = time_of(k);
      const bool closes = k == grid().intervals(j);  // uses x-, before any jump
      const VectorXd x = closes ? trajectory.state_before(t) : trajectory.state(t);
      if (x.size() != nx) continue;  // another phase is active at this time
      is_used = true;
      point.w.segment(layout().state(j, k), nx) = x.cwiseQuotient(phase.nominal_state);
      if (closes || grid().interval(j, k).is_empty()) continue;
      // Sample inside the interval: its ends may belong to neighbours.
      const double next = time_of(k + 1);
      const auto set_input = [&](int first, double at) {
        const VectorXd u = trajectory.input(at);
        if (u.size() != nu) return;
        for (int i = 0; i < nu; ++i) {
          const Bounds b = program_->input_bounds(j, k, i);
          point.w[layout().input(j, k) + first + i] =
              std::clamp(u[i], b.lower, b.upper) / phase.nominal_input[i];
        }
      };
      const bool linear = phase.input_shape() == InputShape::linear;
      constexpr double just_inside = 1e-9;  // fraction of the interval
      set_input(0, linear ? t + just_inside * (next - t) : 0.5 * (t + next));
      if (linear) set_input(nu, next - just_inside * (next - t));
    }
    start += T;
  }
  if (!is_used)
    throw DefinitionError(
        fmt::format("problem '{}': the guess has {} states, but no phase of the problem at its "
                    "times has this number of states: use a trajectory of this problem",
                    problem().name(), trajectory.final_state().size()));
  // A fixed or bounded start overrides the trajectory.
  const PhaseDefinition& first = problem().phases().front();
  for (int i = 0; i < first.sizes.nx; ++i) {
    double& x = point.w[layout().state(0, 0) + i];
    const Bounds& b = data().start_bounds[i];
    x = std::clamp(x, b.lower / first.nominal_state[i], b.upper / first.nominal_state[i]);
  }
  program_->fill_integrals(point.w);
  return point;
}

}  // namespace saltus
