#include "saltus/ocp/phase_definition.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <set>
#include <utility>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "saltus/model/make_function.hpp"
#include "saltus/ocp/phase_limits.hpp"

namespace saltus {
namespace {

[[noreturn]] void fail(const PhaseDefinition& phase, const std::string& what) {
  throw DefinitionError(fmt::format("phase '{}': {}", phase.name, what));
}

[[noreturn]] void fail(const PhaseDefinition& phase, const Term& term, const std::string& what) {
  throw DefinitionError(fmt::format("phase '{}', term '{}': {}", phase.name, term.name, what));
}

void check_bounds(const PhaseDefinition& phase, const std::string& what, const Bounds& b) {
  if (b.is_empty())
    fail(phase, fmt::format("{}: the bounds [{}, {}] are empty", what, b.lower, b.upper));
}

void check_components(const PhaseDefinition& phase, const char* what, int size,
                      const std::vector<PhaseDefinition::ComponentBounds>& bounds) {
  for (const PhaseDefinition::ComponentBounds& b : bounds) {
    if (b.component < 0 || b.component >= size)
      fail(phase, fmt::format("there is no {} {}; the phase has {}, counted from 0", what,
                              b.component, size));
    check_bounds(phase, fmt::format("{} {}", what, b.component), b.bounds);
  }
}

void check_positive(const PhaseDefinition& phase, const char* what, const VectorXd& values,
                    int size) {
  if (values.size() != size)
    fail(phase, fmt::format("{} has {} entries, expected {}", what, values.size(), size));
  for (int i = 0; i < size; ++i)
    if (!(values[i] > 0.0) || std::isinf(values[i]))
      fail(phase, fmt::format("{} {} is {}, expected a positive number", what, i, values[i]));
}

void check_guess(const PhaseDefinition& phase, const char* what, const Guess& guess, int size) {
  if (!guess.is_given()) return;
  for (const double fraction : {0.0, 1.0}) {
    const VectorXd value = guess.at(fraction);
    if (value.size() != size)
      fail(phase, fmt::format("the guess of the {} has {} entries, expected {}", what, value.size(),
                              size));
    if (!value.allFinite()) fail(phase, fmt::format("the guess of the {} is not finite", what));
  }
}

void check_weight(const PhaseDefinition& phase, const Term& term) {
  const int m = term.function.outputs();
  if (term.weight.rows() != m || term.weight.cols() != m)
    fail(phase, term,
         fmt::format("the residual has {} entries, but the weight is {} x {}", m,
                     term.weight.rows(), term.weight.cols()));
  if (!term.weight.allFinite()) fail(phase, term, "the weight is not finite");
  for (int i = 0; i < m; ++i)
    if (term.weight(i, i) < 0.0)
      fail(phase, term,
           fmt::format("weight {} is {}, but weights must not be negative", i, term.weight(i, i)));
  if (!term.reference.is_zero() && term.reference.size() != m)
    fail(phase, term,
         fmt::format("the residual has {} entries, but the reference has {}", m,
                     term.reference.size()));
  if (!term.reference.is_finite()) fail(phase, term, "the reference is not finite");
}

void check_term(const PhaseDefinition& phase, const Term& term) {
  if (term.name.empty()) fail(phase, "a term has no name");
  const int m = term.function.outputs();
  if (term.function.inputs() != phase.sizes.size())
    fail(phase, term,
         fmt::format("the formula takes {} arguments, the phase has {}", term.function.inputs(),
                     phase.sizes.size()));
  if (term.domain != Term::Domain::running &&
      depends_on_any(term.function, phase.sizes.u(), phase.sizes.nu))
    fail(phase, term,
         "it applies at one end of the phase and reads an input, but inputs belong to intervals; "
         "use keep(), minimise() or track() instead");
  if (term.kind == Term::Kind::constraint) {
    if (static_cast<int>(term.bounds.size()) != m)
      fail(phase, term,
           fmt::format("the formula has {} rows, but {} bounds were given", m, term.bounds.size()));
    for (int i = 0; i < m; ++i)
      if (term.bounds[i].is_empty())
        fail(phase, term,
             fmt::format("the bounds [{}, {}] of row {} are empty", term.bounds[i].lower,
                         term.bounds[i].upper, i));
    if (const std::string error = term.soft ? describe_error(*term.soft) : ""; !error.empty())
      fail(phase, term, error);
  } else if (term.kind == Term::Kind::cost && m != 1) {
    fail(phase, term, fmt::format("a cost must be a scalar, but the formula has {} rows", m));
  } else if (term.kind == Term::Kind::least_squares) {
    check_weight(phase, term);
  }
}

}  // namespace

PhaseDefinition::PhaseDefinition() = default;
PhaseDefinition::PhaseDefinition(const PhaseDefinition& other) = default;
PhaseDefinition::PhaseDefinition(PhaseDefinition&& other) noexcept = default;
PhaseDefinition& PhaseDefinition::operator=(const PhaseDefinition& other) = default;
PhaseDefinition& PhaseDefinition::operator=(PhaseDefinition&& other) noexcept = default;
PhaseDefinition::~PhaseDefinition() = default;

double PhaseDefinition::nominal_parameter(int i) const {
  if (i < 0 || i >= sizes.np)
    fail(*this, fmt::format("it has {} parameters, so there is no parameter {}", sizes.np, i));
  for (const PhaseDefinition::ParameterBlock& block : parameters) {
    if (i < block.nominal.size()) return block.nominal[i];
    i -= static_cast<int>(block.nominal.size());
  }
  return 1.0;
}

int PhaseDefinition::integral_index(const std::string& integral) const {
  for (std::size_t i = 0; i < integrals.size(); ++i)
    if (integrals[i].name == integral) return static_cast<int>(i);
  return -1;
}

void PhaseDefinition::check(const Bounds& start) const {
  if (name.empty()) throw DefinitionError("a phase has no name");
  if (dynamics.outputs() != sizes.nx)
    fail(*this, fmt::format("the dynamics return {} entries, but the phase has {} states",
                            dynamics.outputs(), sizes.nx));
  try {
    switching.check(sizes, 0);
  } catch (const DefinitionError& e) {
    fail(*this, e.what());
  }
  if (duration.lower == -infinity)
    fail(*this,
         fmt::format("the duration has no lower bound, and it cannot be negative; write {}",
                     duration.upper < infinity ? fmt::format("between(0.0, {})", duration.upper)
                                               : "at_least(0.0) and set guess_duration()"));
  if (duration.lower == infinity) fail(*this, "the shortest duration must be finite");
  if (duration.is_empty() || duration.lower < 0.0)
    fail(*this, fmt::format("the duration [{}, {}] s is empty or negative", duration.lower,
                            duration.upper));
  if (duration.upper == 0.0) fail(*this, "the duration is 0 s; it must be positive");
  if (has_free_duration() && !(duration_guess > 0.0 && std::isfinite(duration_guess)))
    fail(*this, fmt::format("the free duration needs a positive guess, but it is {} s; use "
                            "guess_duration()",
                            duration_guess));
  if (has_free_duration() && (duration_guess < duration.lower || duration_guess > duration.upper))
    fail(*this, fmt::format("the guess of the duration, {} s, lies outside its bounds [{}, {}] s",
                            duration_guess, duration.lower, duration.upper));
  check_components(*this, "input", sizes.nu, input_bounds);
  check_components(*this, "state", sizes.nx, state_bounds);
  check_positive(*this, "the nominal state", nominal_state, sizes.nx);
  check_positive(*this, "the nominal input", nominal_input, sizes.nu);
  check_positive(*this, "the nominal duration", VectorXd::Constant(1, nominal_duration), 1);
  check_guess(*this, "state", state_guess, sizes.nx);
  check_guess(*this, "input", input_guess, sizes.nu);
  if (input_guess.is_simulated()) fail(*this, "inputs cannot be simulated, only states");

  int np = 0;
  std::set<std::string> block_names;
  for (const PhaseDefinition::ParameterBlock& block : parameters) {
    np += static_cast<int>(block.value.size());
    if (!block_names.insert(block.name).second)
      fail(*this, fmt::format("parameter '{}' is declared twice", block.name));
    if (!block.value.allFinite())
      fail(*this, fmt::format("parameter '{}' is not finite", block.name));
    for (const Bounds& b : block.bounds) check_bounds(*this, "parameter '" + block.name + "'", b);
    check_positive(*this, "the nominal parameter", block.nominal,
                   static_cast<int>(block.value.size()));
  }
  if (np != sizes.np)
    fail(*this,
         fmt::format("it has {} parameters, but data() and unknown() declare {}", sizes.np, np));

  std::set<std::string> term_names;
  for (const Term& term : terms) {
    check_term(*this, term);
    if (!term_names.insert(term.name).second)
      fail(*this, fmt::format("two terms are called '{}'", term.name));
  }
  for (const IntegralConstraint& integral : integrals) {
    saltus::check(*this, integral);
    if (!term_names.insert(integral.name).second)
      fail(*this, fmt::format("two terms are called '{}'", integral.name));
  }
  if (end_guards.size() > 1)
    fail(*this, fmt::format("it has the end events '{}' and '{}', but only one guard can end a "
                            "phase; use reach() for the other",
                            end_guards[0].event, end_guards[1].event));
  for (const EndGuard& guard : end_guards) check_end_guard(*this, guard, start);
  std::vector<int> group_of(sizes.nu, -1);
  for (const int first : resultants) {
    if (resultant_size < 1 || first < 0 || first + resultant_size > sizes.nu)
      fail(*this,
           fmt::format("a common resultant needs {} inputs from {} on, but there are {} inputs",
                       resultant_size, first, sizes.nu));
    for (int i = first; i < first + resultant_size; ++i) {
      if (group_of[i] >= 0)
        fail(*this, fmt::format("input {} is in two groups with a common resultant", i));
      group_of[i] = first;
    }
  }
  if (input_change_weight.size() != 0) {
    if (input_change_weight.size() != sizes.nu)
      fail(*this, fmt::format("penalise_change has {} weights, but there are {} inputs",
                              input_change_weight.size(), sizes.nu));
    if (!(input_change_weight.array() >= 0.0).all() || !input_change_weight.allFinite())
      fail(*this, "penalise_change has a weight that is negative or not finite");
    if (input_parametrisation != InputParametrisation::piecewise_constant)
      fail(*this, "penalise_change is for piecewise constant inputs");
  }
}

void begin(PhaseDefinition& phase, std::string&& name, const Arguments& sizes, Function&& dynamics,
           const Bounds& duration) {
  phase.name = std::move(name);
  phase.sizes = sizes;
  phase.dynamics = std::move(dynamics);
  phase.duration = without_sentinels(duration);
  phase.duration_guess =
      duration.is_equality() ? duration.lower : 0.5 * (phase.duration.lower + phase.duration.upper);
  phase.nominal_state = VectorXd::Ones(sizes.nx);
  phase.nominal_input = VectorXd::Ones(sizes.nu);
}

void add_algebraic(PhaseDefinition& phase, Function&& dynamics, Function&& equations,
                   const VectorXd& guess) {
  try {
    phase.algebraic.equations =
        std::make_shared<const AlgebraicEquations>(phase.sizes, std::move(equations), guess);
  } catch (const DefinitionError& e) {
    fail(phase, e.what());
  }
  phase.algebraic.dynamics = std::move(dynamics);
  phase.dynamics = eliminate(phase.algebraic.dynamics, phase.algebraic.equations);
}

void add_bounds(std::vector<PhaseDefinition::ComponentBounds>& all, int component,
                const Bounds& bounds, Window&& window) {
  all.push_back({component, without_sentinels(bounds), std::move(window)});
}

void add_constraint(PhaseDefinition& phase, std::string&& name, Term::Domain domain,
                    Function&& function, std::vector<Bounds>&& bounds, Window&& window,
                    std::optional<Penalty>&& penalty) {
  if (bounds.size() == 1) bounds.resize(function.outputs(), bounds.front());
  for (Bounds& b : bounds) b = without_sentinels(b);
  phase.terms.push_back({.name = std::move(name),
                         .kind = Term::Kind::constraint,
                         .domain = domain,
                         .function = std::move(function),
                         .bounds = std::move(bounds),
                         .soft = std::move(penalty),
                         .weight = {},
                         .reference = {},
                         .window = std::move(window)});
}

void add_end_guard(PhaseDefinition& phase, std::string&& event, Function&& guard,
                   Crossing crossing) {
  add_constraint(phase, std::string(event), Term::Domain::phase_end, Function(guard),
                 {exactly(0.0)}, {}, std::nullopt);
  phase.end_guards.push_back({std::move(event), std::move(guard), crossing});
}

void add_allowance(PhaseDefinition& phase, std::string&& term, double between_nodes,
                   double at_nodes) {
  std::vector<std::string> known;
  for (const Term& t : phase.terms)
    if (t.kind == Term::Kind::constraint) known.push_back(t.name);
  for (const PhaseDefinition::ComponentBounds& b : phase.state_bounds)
    known.push_back(fmt::format("bounds of state {}", b.component));
  if (std::ranges::find(known, term) == known.end())
    fail(phase, fmt::format("allow() names '{}', which is not a constraint declared before{}", term,
                            did_you_mean(term, known)));
  if (!(between_nodes > 0.0 && std::isfinite(between_nodes)))
    fail(phase, fmt::format("allow(\"{}\") is given {} between the nodes, expected a positive "
                            "number",
                            term, between_nodes));
  if (!(at_nodes >= 0.0 && std::isfinite(at_nodes)))
    fail(phase,
         fmt::format("allow(\"{}\") is given {} at nodes, expected a number that is not negative",
                     term, at_nodes));
  phase.allowances.push_back({std::move(term), between_nodes, at_nodes});
}

void add_cost(PhaseDefinition& phase, std::string&& name, Term::Domain domain, Function&& function,
              Window&& window) {
  phase.terms.push_back({.name = std::move(name),
                         .kind = Term::Kind::cost,
                         .domain = domain,
                         .function = std::move(function),
                         .bounds = {},
                         .weight = {},
                         .reference = {},
                         .window = std::move(window)});
}

void add_least_squares(PhaseDefinition& phase, std::string&& name, Term::Domain domain,
                       Function&& residual, const VectorXd& weights, Window&& window,
                       Reference&& reference) {
  phase.terms.push_back({.name = std::move(name),
                         .kind = Term::Kind::least_squares,
                         .domain = domain,
                         .function = std::move(residual),
                         .bounds = {},
                         .weight = weights.asDiagonal(),
                         .reference = std::move(reference),
                         .window = std::move(window)});
}

void add_parameter(PhaseDefinition& phase, std::string&& name, const VectorXd& value,
                   std::span<const ParameterEntry> entries) {
  phase.parameters.push_back(
      {std::move(name), value, false, {}, VectorXd::Ones(value.size()), entries});
}

void make_unknown(PhaseDefinition& phase, const Bounds& bounds, double magnitude) {
  PhaseDefinition::ParameterBlock& block = phase.parameters.back();
  block.unknown = true;
  block.bounds.assign(block.value.size(), without_sentinels(bounds));
  block.nominal.setConstant(magnitude);
}

}  // namespace saltus
