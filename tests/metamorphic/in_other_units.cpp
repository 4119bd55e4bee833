// The law of units: states, inputs, time and cost change units, and bounds, guesses and weights are
// converted. With t = tau t', x = s x', u = r u' and J = kappa J':
//
//     x'' = f tau / s,   running costs times tau / kappa,   costs at ends divided by kappa.
//
// Magnitudes are converted only where they were declared.
#include <fmt/format.h>

#include <cmath>

#include "tests/metamorphic/laws.hpp"
#include "tests/metamorphic/scaled_function.hpp"

namespace saltus::metamorphic {
namespace {

struct Units {
  double time = 1.0, cost = 1.0;
  VectorXd state, input;  // the size of the largest phase
};

Bounds divided(const Bounds& b, double unit) { return {b.lower / unit, b.upper / unit}; }

VectorXd argument_units(const Units& units, const Arguments& sizes) {
  VectorXd z = VectorXd::Ones(sizes.size());
  z[sizes.t()] = units.time;
  z.segment(sizes.x(), sizes.nx) = units.state.head(sizes.nx);
  z.segment(sizes.u(), sizes.nu) = units.input.head(sizes.nu);
  return z;
}

Guess converted(const Guess& guess, const VectorXd& units) {
  if (guess.is_simulated() || !guess.is_given()) return guess;
  return Guess::trajectory([=](double f) { return guess.at(f).cwiseQuotient(units).eval(); });
}

void convert(PhaseDefinition& phase, const Units& units) {
  const Arguments sizes = phase.sizes;
  const VectorXd z = argument_units(units, sizes);
  const VectorXd x = units.state.head(sizes.nx), u = units.input.head(sizes.nu);
  const auto ones = [](const Function& f) { return VectorXd::Ones(f.outputs()).eval(); };
  phase.dynamics = scaled(phase.dynamics, z, units.time * x.cwiseInverse());
  for (auto& mode : phase.switching.modes)
    mode.dynamics = scaled(mode.dynamics, z, units.time * x.cwiseInverse());
  for (auto& transition : phase.switching.transitions) {
    transition.guard = scaled(transition.guard, z, ones(transition.guard));
    if (transition.reset) transition.reset = scaled(transition.reset, z, x.cwiseInverse());
  }
  phase.duration = divided(phase.duration, units.time);
  phase.duration_guess /= units.time;
  for (PhaseDefinition::ComponentBounds& b : phase.state_bounds)
    b.bounds = divided(b.bounds, x[b.component]);
  for (PhaseDefinition::ComponentBounds& b : phase.input_bounds)
    b.bounds = divided(b.bounds, u[b.component]);
  for (Term& term : phase.terms) {
    const double factor = (term.domain == Term::Domain::running ? units.time : 1.0) / units.cost;
    VectorXd rows = ones(term.function);
    if (term.kind == Term::Kind::cost) rows *= factor;
    term.function = scaled(term.function, z, rows);
    if (term.kind == Term::Kind::least_squares) term.weight *= factor;
    if (term.soft) term.soft->weight *= factor;
  }
  for (IntegralConstraint& integral : phase.integrals) {
    integral.integrand = scaled(integral.integrand, z, VectorXd::Constant(1, units.time));
    if (integral.limits.soft) integral.limits.soft->weight /= units.cost;
  }
  for (EndGuard& guard : phase.end_guards) guard.guard = scaled(guard.guard, z, ones(guard.guard));
  if (phase.input_change_weight.size() > 0)
    phase.input_change_weight =
        phase.input_change_weight.cwiseProduct(u).cwiseProduct(u) / units.cost;
  const auto is_declared = [&](const VectorXd& nominal) {
    return nominal.size() > 0 && (phase.has_nominal || !nominal.isOnes());
  };
  if (is_declared(phase.nominal_state)) phase.nominal_state = phase.nominal_state.cwiseQuotient(x);
  if (is_declared(phase.nominal_input)) phase.nominal_input = phase.nominal_input.cwiseQuotient(u);
  if (phase.has_nominal_duration || phase.nominal_duration != 1.0)
    phase.nominal_duration /= units.time;
  phase.state_guess = converted(phase.state_guess, x);
  phase.input_guess = converted(phase.input_guess, u);
}

// Reason why the time cannot be converted from outside, or empty if it can.
std::string fixed_time(const Stated& stated) {
  if (!stated.problem.schedule().events().empty()) return "a schedule";
  for (const PhaseDefinition& phase : stated.problem.phases()) {
    for (const Term& term : phase.terms) {
      if (!term.window.is_whole()) return "a window";
      if (term.reference.varies()) return "a time-varying reference";
    }
    for (const auto* all : {&phase.state_bounds, &phase.input_bounds})
      for (const PhaseDefinition::ComponentBounds& b : *all)
        if (!b.window.is_whole()) return "a window";
    if (phase.input_change_weight.size() > 0) return "a cost of input changes";
  }
  return {};
}

}  // namespace

std::optional<Transformed> in_other_units(const Stated& stated, const Solution&, Random& random,
                                          std::string& why) {
  int nx = 0, nu = 0;
  for (const PhaseDefinition& phase : stated.problem.phases()) {
    if (phase.algebraic.equations != nullptr) {
      why = "functions behind algebraic states cannot be composed from outside";
      return {};
    }
    nx = std::max(nx, phase.sizes.nx);
    nu = std::max(nu, phase.sizes.nu);
  }
  Units units{1.0, 1.0, VectorXd::Ones(nx), VectorXd::Ones(nu)};
  const int which = 1 << random.integer(0, 3);
  if (which & 1)
    for (double& s : units.state) s = random.log_uniform(1e-6, 1e6);
  if (which & 2)
    for (double& s : units.input) s = random.log_uniform(1e-6, 1e6);
  if ((which & 4) && fixed_time(stated).empty()) units.time = random.log_uniform(1e-6, 1e6);
  if ((which & 8) || ((which & 4) && units.time == 1.0) || ((which & 2) && nu == 0))
    units.cost = random.log_uniform(1e-6, 1e6);
  for (const PhaseDefinition& phase : stated.problem.phases())
    if (phase.switching.memory >= 0) units.state[phase.switching.memory] = 1.0;

  const auto& phases = stated.problem.phases();
  const auto jump = [&](int j, const Jump& old) {
    if (!old.map) return old;
    const int before = j > 0 ? j - 1 : static_cast<int>(phases.size()) - 1;
    VectorXd z = VectorXd::Ones(old.map.inputs());
    z[0] = units.time;
    z.segment(1, phases[before].sizes.nx) = units.state.head(phases[before].sizes.nx);
    Jump converted = old;
    converted.map = scaled(old.map, z, units.state.head(phases[j].sizes.nx).cwiseInverse());
    return converted;
  };
  OptimalControlProblem problem = rebuilt(
      stated.problem, [&](int, PhaseDefinition& phase) { convert(phase, units); }, jump);
  std::vector<Bounds> start = stated.problem.start_bounds();
  for (std::size_t i = 0; i < start.size(); ++i) start[i] = divided(start[i], units.state[i]);
  problem.start_within(start, stated.problem.start_guess().cwiseQuotient(
                                  units.state.head(stated.problem.start_guess().size())));
  if (stated.problem.start_time_bounds())
    problem.start_time(divided(*stated.problem.start_time_bounds(), units.time),
                       stated.problem.start_time() / units.time);
  else
    problem.start_time(stated.problem.start_time() / units.time);
  problem.total_time(divided(stated.problem.total_time(), units.time));
  for (std::size_t l = 0; l < stated.problem.links().size(); ++l) {
    Link& link = problem.editable_link(static_cast<int>(l));
    VectorXd z = VectorXd::Ones(link.function.inputs());
    int next = 1;  // after a time that a link does not read
    for (const Link::End& end : link.ends) {
      z[next] = z[next + 1] = units.time;
      z.segment(next + 2, end.nx) = units.state.head(end.nx);
      next += end.size();
    }
    link.function = scaled(link.function, z, VectorXd::Ones(link.function.outputs()));
    if (link.limits.soft) link.limits.soft->weight /= units.cost;
  }
  Transformed t{.stated = {std::move(problem), stated.options}};
  t.cost_factor = 1.0 / units.cost;
  t.units.time = 1.0 / units.time;
  for (const PhaseDefinition& phase : phases) {
    t.units.state.push_back(units.state.head(phase.sizes.nx).cwiseInverse());
    t.units.input.push_back(units.input.head(phase.sizes.nu).cwiseInverse());
  }
  t.what = fmt::format("time {:.2g}, cost {:.2g}", units.time, units.cost);
  for (int i = 0; i < nx; ++i) t.what += fmt::format(", x{} {:.2g}", i, units.state[i]);
  for (int i = 0; i < nu; ++i) t.what += fmt::format(", u{} {:.2g}", i, units.input[i]);
  return t;
}

}  // namespace saltus::metamorphic
