#include "benchmarks/suite/shooting_steps.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>
#include <optional>
#include <tuple>

#include "saltus/core/error.hpp"
#include "saltus/integrators/explicit_steps.hpp"
#include "saltus/model/steps_of.hpp"
#include "saltus/ocp/cost_functions.hpp"

namespace saltus::bench {
namespace {

using Steps = std::vector<int>;  // indices of a FormulaSteps

FormulaSteps with_inputs(int count) {
  FormulaSteps f;
  f.inputs = count;
  for (int i = 0; i < count; ++i) f.add_input(i);  // step i is input i
  return f;
}

Steps range(int first, int count) {
  Steps all(count);
  for (int i = 0; i < count; ++i) all[i] = first + i;
  return all;
}

int product(FormulaSteps& f, double a, int b) {
  return a == 1.0 ? b : f.add(Operation::multiply, f.add_constant(a), b);
}

// sum = -1: empty
int sum(FormulaSteps& f, int sum, int term) {
  return sum < 0 ? term : f.add(Operation::add, sum, term);
}

// Value of a cost term: the formula, or half the weighted square of its difference from the
// reference.
FormulaSteps cost_steps(const Term& term) {
  FormulaSteps formula = steps_of(term.function);
  if (term.kind != Term::Kind::least_squares) return formula;
  if (term.reference.varies())
    throw DefinitionError(fmt::format("term '{}': its reference depends on time", term.name));
  FormulaSteps f = with_inputs(formula.inputs);
  Steps r = f.add(formula, range(0, formula.inputs));
  if (!term.reference.is_zero())
    for (std::size_t i = 0; i < r.size(); ++i)
      r[i] = f.add(Operation::subtract, r[i],
                   f.add_constant(term.reference.at(0.0, static_cast<int>(i))));
  int total = -1;
  for (std::size_t i = 0; i < r.size(); ++i)
    for (std::size_t j = 0; j < r.size(); ++j) {
      const double weight = term.weight(static_cast<int>(i), static_cast<int>(j));
      if (weight == 0.0) continue;
      total = sum(f, total, product(f, 0.5 * weight, f.add(Operation::multiply, r[i], r[j])));
    }
  f.outputs = {total < 0 ? f.add_constant(0.0) : total};
  return f;
}

// (z | h) -> h L(z)
FormulaSteps times_length_steps(const FormulaSteps& cost) {
  FormulaSteps f = with_inputs(cost.inputs + 1);
  const Steps value = f.add(cost, range(0, cost.inputs));
  f.outputs = {f.add(Operation::multiply, value.front(), cost.inputs)};
  return f;
}

FormulaSteps change_steps(const VectorXd& weights) {
  const int n = static_cast<int>(weights.size());
  FormulaSteps f = with_inputs(2 * n);
  for (int i = 0; i < n; ++i) {
    const int change = f.add(Operation::subtract, n + i, i);
    f.outputs.push_back(product(f, 0.5 * weights[i], f.add(Operation::multiply, change, change)));
  }
  return f;
}

// (t | slack | length) -> length times slack, or half its square
FormulaSteps penalty_steps(bool is_quadratic) {
  FormulaSteps f = with_inputs(3);
  int cost = 1;
  if (is_quadratic) cost = product(f, 0.5, f.add(Operation::multiply, 1, 1));
  f.outputs = {f.add(Operation::multiply, cost, 2)};
  return f;
}

// w = (x0 | c | p | t0 | h) -> (x(t0 + h) | q): interval_field.hpp and runge_kutta.cpp in symbols.
FormulaSteps interval_steps(const Integrator& integrator, const std::vector<FormulaSteps>& costs,
                            const ExplicitSteps& scheme) {
  const IntervalProblem& problem = integrator.problem();
  const IntervalArguments at = integrator.arguments();
  const Arguments& sizes = problem.arguments;
  const FormulaSteps dynamics = steps_of(problem.dynamics);
  const ButcherTableau& tableau = scheme.tableau;
  FormulaSteps f = with_inputs(at.size());

  // h phi at scaled time s and state x
  const auto rate = [&](double s, const Steps& x) {
    Steps z;
    z.push_back(f.add(Operation::add, at.t0(), product(f, s, at.h())));
    z.insert(z.end(), x.begin(), x.begin() + sizes.nx);
    for (int i = 0; i < sizes.nu; ++i) {
      int u = at.c(i);
      if (problem.shape == InputShape::linear) {
        const int rise = f.add(Operation::subtract, at.c(sizes.nu + i), at.c(i));
        u = f.add(Operation::add, u, product(f, s, rise));
      }
      z.push_back(u);
    }
    for (int i = 0; i < sizes.np; ++i) z.push_back(at.p(i));
    Steps phi = f.add(dynamics, z);
    for (const FormulaSteps& cost : costs) phi.push_back(f.add(cost, z).front());
    for (int& entry : phi) entry = f.add(Operation::multiply, at.h(), entry);
    return phi;
  };
  // y + step sum_i coefficients_i rates_i
  const auto advanced = [&](const Steps& y, const auto& coefficients,
                            const std::vector<Steps>& rates) {
    Steps result = y;
    for (std::size_t r = 0; r < y.size(); ++r) {
      int total = -1;
      for (std::size_t i = 0; i < rates.size(); ++i)
        if (coefficients[static_cast<int>(i)] != 0.0)
          total = sum(f, total,
                      product(f, coefficients[static_cast<int>(i)] / scheme.steps, rates[i][r]));
      if (total >= 0) result[r] = f.add(Operation::add, y[r], total);
    }
    return result;
  };

  Steps y = range(at.x(), sizes.nx);
  for (std::size_t q = 0; q < costs.size(); ++q) y.push_back(f.add_constant(0.0));
  for (int n = 0; n < scheme.steps; ++n) {
    std::vector<Steps> rates;
    rates.reserve(static_cast<std::size_t>(tableau.stages()));
    for (int i = 0; i < tableau.stages(); ++i)
      rates.push_back(rate((n + tableau.c[i]) / scheme.steps,
                           advanced(y, VectorXd(tableau.a.row(i).transpose()), rates)));
    y = advanced(y, tableau.b, rates);
  }
  f.outputs = y;
  f.prune();
  return f;
}

enum class Kind { interval, row, cost, cost_times_length, jump, change, penalty, link };
// Key of a block: blocks with the same kind, phase and term share their function.
using Meaning = std::tuple<Kind, int, int>;

class Writer {
 public:
  Writer(const ShootingProgram& program, const IntegratorScheme& scheme, const VectorXd& start)
      : program_(program), scheme_(scheme), start_(start) {}

  ShootingSteps write() {
    ShootingSteps result;
    std::map<Meaning, int> known;
    const std::vector<Meaning> meanings = meanings_of_blocks();
    for (std::size_t b = 0; b < program_.blocks().size(); ++b) {
      const Block& block = program_.blocks()[b];
      if (!counts(block)) {
        result.function_of.push_back(-1);
        continue;
      }
      const auto [at, is_new] =
          known.emplace(meanings[b], static_cast<int>(result.functions.size()));
      if (is_new) {
        result.functions.push_back(steps_for(meanings[b], block));
        check_steps(result.functions.back(), block.function, argument_of(block), "a block");
      }
      result.function_of.push_back(at->second);
    }
    return result;
  }

 private:
  bool counts(const Block& block) const {
    return std::any_of(block.outputs.begin(), block.outputs.end(), [&](const BlockOutput& o) {
      return o.factor != 0.0 &&
             (o.row == BlockOutput::objective || std::isfinite(program_.row_lower()[o.row]) ||
              std::isfinite(program_.row_upper()[o.row]));
    });
  }

  VectorXd argument_of(const Block& block) const {
    VectorXd z = block.constants;
    for (int i = 0; i < z.size(); ++i)
      for (const VariableCoefficient& c : block.coefficients[i])
        z[i] += c.factor * start_[c.variable];
    return z;
  }

  std::vector<Meaning> meanings_of_blocks() const {
    std::vector<std::optional<Meaning>> meaning(program_.blocks().size());
    std::map<int, int> block_of_row;
    for (std::size_t b = 0; b < program_.blocks().size(); ++b)
      for (const BlockOutput& o : program_.blocks()[b].outputs)
        if (o.row != BlockOutput::objective) block_of_row[o.row] = static_cast<int>(b);
    for (const shooting::IntervalInstance& i : program_.interval_instances())
      meaning[i.block] = {Kind::interval, i.phase, 0};
    for (const shooting::RowInstance& i : program_.row_instances())
      meaning[i.block.block] = {Kind::row, i.phase, i.term};
    for (const shooting::CostInstance& i : program_.cost_instances())
      if (!meaning[i.block])
        meaning[i.block] = {i.length_inside ? Kind::cost_times_length : Kind::cost, i.phase,
                            i.term};
    for (const shooting::ChangeInstance& i : program_.change_instances())
      meaning[i.block] = {Kind::change, i.phase, 0};
    const int phases = static_cast<int>(program_.problem().phases().size());
    for (int j = 1; j < phases; ++j)
      if (const auto at = block_of_row.find(program_.jump_row(j)); at != block_of_row.end())
        meaning[at->second] = {Kind::jump, j, 0};
    if (program_.closing_row() >= 0)
      if (const auto at = block_of_row.find(program_.closing_row()); at != block_of_row.end())
        meaning[at->second] = {Kind::jump, 0, 0};
    for (std::size_t b = 0; b < meaning.size(); ++b)
      if (!meaning[b] && program_.blocks()[b].function.inputs() == 3)
        meaning[b] = {Kind::penalty, is_quadratic(program_.blocks()[b]) ? 1 : 0, 0};
    std::vector<Meaning> all;
    all.reserve(meaning.size());
    for (std::size_t b = 0; b < meaning.size(); ++b)
      all.push_back(meaning[b].value_or(Meaning{Kind::link, static_cast<int>(b), 0}));
    return all;
  }

  // length times slack, or half its square: at a slack of 4 they are 4 and 8
  static bool is_quadratic(const Block& penalty) {
    return penalty.function(Eigen::Vector3d(0.0, 4.0, 1.0))[0] > 6.0;
  }

  FormulaSteps steps_for(const Meaning& meaning, const Block& block) const {
    const auto [kind, phase, term] = meaning;
    const OptimalControlProblem& problem = program_.problem();
    switch (kind) {
      case Kind::interval:
        return interval(phase);
      case Kind::row:
        return steps_of(problem.phases()[phase].terms[term].function);
      case Kind::cost:
        return cost_steps(problem.phases()[phase].terms[term]);
      case Kind::cost_times_length:
        return times_length_steps(cost_steps(problem.phases()[phase].terms[term]));
      case Kind::jump:
      case Kind::link:
        return steps_of(block.function);
      case Kind::change:
        return change_steps(problem.phases()[phase].input_change_weight);
      case Kind::penalty:
        return penalty_steps(phase == 1);
    }
    return {};
  }

  FormulaSteps interval(int j) const {
    const PhaseDefinition& phase = program_.problem().phases()[j];
    const Integrator& integrator = *program_.integrators()[j];
    if (!integrator.problem().switching.empty())
      throw DefinitionError(fmt::format("phase '{}' has events inside its intervals", phase.name));
    if (integrator.problem().algebraic.equations)
      throw DefinitionError(fmt::format("phase '{}' has algebraic equations", phase.name));
    const std::optional<ExplicitSteps> scheme = explicit_steps(scheme_);
    if (!scheme)
      throw DefinitionError(
          fmt::format("the integrator '{}' has no fixed explicit steps", scheme_.name()));
    std::vector<FormulaSteps> costs;
    if (program_.problem().cost_rule(j) == CostRule::integrated)
      for (const Term& term : phase.terms)
        if (term.kind != Term::Kind::constraint && term.domain == Term::Domain::running)
          costs.push_back(cost_steps(term));
    for (const IntegralConstraint& integral : phase.integrals)
      costs.push_back(steps_of(integral.integrand));
    return interval_steps(integrator, costs, *scheme);
  }

  const ShootingProgram& program_;
  const IntegratorScheme& scheme_;
  const VectorXd& start_;
};

}  // namespace

ShootingSteps shooting_steps(const ShootingProgram& program, const IntegratorScheme& scheme,
                             const VectorXd& start) {
  return Writer(program, scheme, start).write();
}

}  // namespace saltus::bench
