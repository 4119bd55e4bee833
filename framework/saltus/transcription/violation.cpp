#include "saltus/transcription/violation.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

namespace saltus {

using namespace shooting;

namespace {

constexpr double reported_violation = 1e-7;  // ten times the residual of a good solution
// For terms in conflict: smallest multiplier relative to the largest, and maximum number of terms.
constexpr double reported_multiplier_share = 1e-3;
constexpr int max_reported_terms = 3;

double miss(double value, double lower, double upper) {
  return std::max({lower - value, value - upper, 0.0});
}

struct Violation {
  double amount = 0.0;
  std::string what;

  template <class Describe>
  void consider(double other, Describe&& describe) {
    if (!(other > amount)) return;
    amount = other;
    what = describe();
  }
};

// Searches the user's conditions: hard terms, bounds on states, closing rows and the total time.
Violation worst_of_terms(ShootingProgram& program, const VectorXd& w) {
  Violation worst;
  VectorXd g(program.rows());
  if (!program.constraints(w.data(), g.data())) return worst;
  const auto consider_row = [&](int row) {
    worst.consider(miss(g[row], program.row_lower()[row], program.row_upper()[row]),
                   [&] { return program.describe_row(row, &w); });
  };
  for (const RowInstance& instance : program.row_instances()) {
    const Term& term = program.problem().phases()[instance.phase].terms[instance.term];
    if (term.soft) continue;
    for (int i = 0; i < term.function.outputs(); ++i) consider_row(instance.first_row + i);
  }
  if (program.closing_row() >= 0)
    for (int i = 0; i < program.problem().phases().front().sizes.nx; ++i)
      consider_row(program.closing_row() + i);
  if (program.total_time_row() >= 0) consider_row(program.total_time_row());
  for (const LimitInstance& instance : program.limit_instances())
    for (int i = 0; i < instance.count && !program.limits_of(instance).soft; ++i)
      consider_row(instance.first_row + i);
  for (int j = 0; j < program.grid().phases(); ++j) {
    const PhaseDefinition& phase = program.problem().phases()[j];
    for (int node = 0; node <= program.grid().intervals(j); ++node)
      for (int i = 0; i < phase.sizes.nx; ++i) {
        const int v = program.layout().state(j, node) + i;
        worst.consider(
            phase.nominal_state[i] * miss(w[v], program.lower()[v], program.upper()[v]), [&] {
              return fmt::format("phase '{}', bounds of state {} at t = {:.6g} s", phase.name, i,
                                 program.time_of({.phase = j, .node = node}, &w));
            });
      }
  }
  return worst;
}

Violation worst_of_rows(ShootingProgram& program, const VectorXd& w) {
  Violation worst;
  VectorXd g(program.rows());
  if (!program.constraints(w.data(), g.data())) return worst;
  for (int row = 0; row < program.rows(); ++row)
    worst.consider(miss(g[row], program.row_lower()[row], program.row_upper()[row]),
                   [&] { return program.describe_row(row, &w); });
  return worst;
}

// Replaces the states of w by those that its inputs give from its start. Returns false if they are
// not finite.
bool close_gaps(const ShootingProgram& program, VectorXd& w) {
  VectorXd x;
  for (int j = 0; j < program.grid().phases(); ++j) {
    const PhaseDefinition& phase = program.problem().phases()[j];
    const int nx = phase.sizes.nx;
    const VectorXd p = program.parameters_of(j, &w);
    const double start = program.start_of(j, &w), T = program.duration_of(j, &w);
    const auto stored = [&](int node) { return w.segment(program.layout().state(j, node), nx); };
    if (j == 0) {
      x = stored(0).cwiseProduct(phase.nominal_state);
      for (int i = 0; i < nx; ++i)
        x[i] = std::clamp(x[i], program.data().start_bounds[i].lower,
                          program.data().start_bounds[i].upper);
    }
    Integrator& integrator = *program.integrators()[j];
    const IntervalArguments a = integrator.arguments();
    VectorXd argument(a.size()), end(integrator.outputs()), c(a.nc);
    stored(0) = x.cwiseQuotient(phase.nominal_state);
    for (int k = 0; k < program.grid().intervals(j); ++k) {
      for (int i = 0; i < a.nc; ++i)
        c[i] = w[program.layout().input(j, k) + i] * phase.nominal_input[i % phase.sizes.nu];
      const Grid::Interval& interval = program.grid().interval(j, k);
      argument << x, c, p, start + interval.offset(T), interval.length(T);
      if (integrator.value(argument.data(), end.data()) != IntegrationStatus::success) return false;
      x = end.head(nx);
      stored(k + 1) = x.cwiseQuotient(phase.nominal_state);
    }
    if (j + 1 < program.grid().phases())
      x = program.problem().jumps()[j + 1].apply(start + T, x, p);
    if (!x.allFinite()) return false;
  }
  return true;
}

// Multiplier of a term, link or integral in the least violation.
struct Pull {
  std::string name;
  double force = 0.0;
};

}  // namespace

std::string describe_conflict(const ShootingProgram& program, const VectorXd& lambda,
                              const std::string& violated) {
  if (lambda.size() != program.rows()) return {};
  std::vector<Pull> pulls;
  for (const RowInstance& instance : program.row_instances()) {
    const PhaseDefinition& phase = program.problem().phases()[instance.phase];
    const Term& term = phase.terms[instance.term];
    if (term.soft) continue;
    double force = 0.0;
    for (int i = 0; i < term.function.outputs(); ++i)
      force = std::max(force, std::abs(lambda[instance.first_row + i]));
    std::string name = fmt::format("phase '{}', term '{}'", phase.name, term.name);
    const auto known =
        std::find_if(pulls.begin(), pulls.end(), [&](const Pull& p) { return p.name == name; });
    if (known == pulls.end())
      pulls.push_back({std::move(name), force});
    else
      known->force = std::max(known->force, force);
  }
  for (const LimitInstance& instance : program.limit_instances()) {
    if (program.limits_of(instance).soft) continue;
    const double force =
        lambda.segment(instance.first_row, instance.count).lpNorm<Eigen::Infinity>();
    pulls.push_back({program.describe_limit(instance), force});
  }
  std::stable_sort(pulls.begin(), pulls.end(),
                   [](const Pull& a, const Pull& b) { return a.force > b.force; });
  std::string names;
  int count = 0;
  for (const Pull& p : pulls) {
    if (!(p.force > reported_multiplier_share * pulls.front().force) || count == max_reported_terms)
      break;
    if (violated.find(p.name) != std::string::npos) continue;
    names += (count++ > 0 ? "; " : "") + p.name;
  }
  return names.empty() ? names : "in conflict with " + names;
}

std::string describe_violation(ShootingProgram& program, const VectorXd& w) {
  const Violation any = worst_of_rows(program, w);
  Violation named = worst_of_terms(program, w);
  if (any.amount > reported_violation && any.amount > named.amount) {  // a defect of the dynamics
    VectorXd simulated = w;
    Violation closed;
    if (close_gaps(program, simulated)) closed = worst_of_terms(program, simulated);
    named = closed.amount > reported_violation ? closed : any;
  }
  if (!(named.amount > reported_violation)) return {};
  return fmt::format("{} violates its bounds by {:.3g}", named.what, named.amount);
}

std::string describe_contradiction(const ShootingProgram& program,
                                   const NlpResult::Contradiction& c, const VectorXd& w) {
  if (c.row < 0)
    return fmt::format(
        "the bounds of {} contradict those of a variable that must equal it, by {:.3g}",
        program.describe_variable(c.variable), c.amount);
  std::string text =
      fmt::format("{} violates its bounds by {:.3g}", program.describe_row(c.row, &w), c.amount);
  if (c.other_row >= 0)
    text += fmt::format(" where {} holds", program.describe_row(c.other_row, &w));
  else if (c.variable >= 0)
    text += fmt::format(" within the bounds of {}", program.describe_variable(c.variable));
  else
    text += " for every choice: it depends on no free variable";
  return text;
}

std::string first_phase_with_events(const OptimalControlProblem& problem) {
  for (const PhaseDefinition& phase : problem.phases())
    if (!phase.switching.empty()) return phase.name;
  return {};
}

std::string events_hint(const std::string& phase) {
  return fmt::format(
      "phase '{}': its events make the problem discontinuous: try another guess, fewer intervals, "
      "or separate phases",
      phase);
}

}  // namespace saltus
