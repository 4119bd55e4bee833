#include "saltus/ocp/phase_limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"

namespace saltus {
namespace {

[[noreturn]] void fail(const PhaseDefinition& phase, const std::string& what) {
  throw DefinitionError(fmt::format("phase '{}': {}", phase.name, what));
}

// "state 2", with a number appended if the term already exists.
std::string free_name(const PhaseDefinition& phase, const char* what, int component) {
  std::string name = fmt::format("{} {}", what, component);
  for (int again = 2; std::any_of(phase.terms.begin(), phase.terms.end(),
                                  [&](const Term& term) { return term.name == name; });
       ++again)
    name = fmt::format("{} {}, {}", what, component, again);
  return name;
}

// Entry i of the argument (t | x | u | p).
class Entry final : public FunctionBody {
 public:
  Entry(int inputs, int i) : FunctionBody(inputs, 1), i_(i) {
    jacobian_pattern_ = SparsityPattern::from_pairs(1, inputs, {{0, i}});
    hessian_pattern_ = SparsityPattern::from_pairs(inputs, inputs, {});
  }
  bool is_reentrant() const override { return true; }
  int degree(int, const std::vector<char>& variable) const override { return variable[i_] ? 1 : 0; }
  void value(const double* z, double* y) const override { *y = z[i_]; }
  void jacobian(const double* z, double* y, double* entries) const override {
    *y = z[i_];
    *entries = 1.0;
  }
  void hessian(const double*, const double*, double*, Curvature) const override {}

 private:
  int i_;
};

}  // namespace

void check(const PhaseDefinition& phase, const IntegralConstraint& integral) {
  const std::string where = "integral '" + integral.name + "'";
  if (integral.name.empty()) fail(phase, "an integral has no name");
  if (integral.integrand.inputs() != phase.sizes.size())
    fail(phase, fmt::format("{}: the formula takes {} arguments, the phase has {}", where,
                            integral.integrand.inputs(), phase.sizes.size()));
  if (integral.integrand.outputs() != 1)
    fail(phase, fmt::format("{}: it must be a scalar, but the formula has {} rows", where,
                            integral.integrand.outputs()));
  if (integral.limits.bounds.size() != 1)
    fail(phase, fmt::format("{}: it is a scalar, but {} bounds were given", where,
                            integral.limits.bounds.size()));
  if (const Bounds& b = integral.limits.bounds.front(); b.is_empty())
    fail(phase, fmt::format("{}: the bounds [{}, {}] are empty", where, b.lower, b.upper));
  if (!(integral.magnitude > 0.0) || std::isinf(integral.magnitude))
    fail(phase, fmt::format("{}: its magnitude is {}, expected a positive number", where,
                            integral.magnitude));
  if (integral.limits.soft)
    if (const std::string error = describe_error(*integral.limits.soft); !error.empty())
      fail(phase, where + ": " + error);
}

void add_algebraic_bounds(PhaseDefinition& phase, int component, const Bounds& bounds,
                          Window&& window, std::optional<Penalty>&& penalty) {
  const AlgebraicEquations& equations = *phase.algebraic.equations;
  if (component < 0 || component >= equations.count())
    fail(phase, fmt::format("there is no algebraic state {}; the phase has {}, counted from 0",
                            component, equations.count()));
  add_constraint(phase, free_name(phase, "algebraic state", component), Term::Domain::running,
                 algebraic_state(phase.algebraic.equations, component), {bounds}, std::move(window),
                 std::move(penalty));
}

void add_soft_bounds(PhaseDefinition& phase, const char* what, int first, int count, int component,
                     const Bounds& bounds, Window&& window, Penalty&& penalty) {
  if (component < 0 || component >= count)
    fail(phase, fmt::format("there is no {} {}; the phase has {}, counted from 0", what, component,
                            count));
  add_constraint(phase, free_name(phase, what, component), Term::Domain::running,
                 Function(std::make_shared<const Entry>(phase.sizes.size(), first + component)),
                 {bounds}, std::move(window), std::move(penalty));
}

void add_integral(PhaseDefinition& phase, std::string&& name, Function&& integrand, Limits&& limits,
                  double magnitude) {
  for (Bounds& b : limits.bounds) b = without_sentinels(b);
  phase.integrals.push_back({std::move(name), std::move(integrand), std::move(limits), magnitude});
}

}  // namespace saltus
