// Warnings about valid definitions that look like mistakes: costs without influence, constraints
// that no trajectory changes, and unused quantities.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/ocp/term_reads.hpp"

namespace saltus {
namespace {

std::vector<Function> fields_of(const PhaseDefinition& phase) {
  if (phase.switching.empty()) return {phase.dynamics};
  std::vector<Function> fields;
  for (const auto& mode : phase.switching.modes) fields.push_back(mode.dynamics);
  return fields;
}

// All functions of a phase except its dynamics.
std::vector<Function> non_dynamics_functions(const PhaseDefinition& phase) {
  std::vector<Function> others;
  for (const Term& term : phase.terms) others.push_back(term.function);
  for (const IntegralConstraint& integral : phase.integrals) others.push_back(integral.integrand);
  for (const auto& mode : phase.switching.modes)
    if (mode.running_cost) others.push_back(mode.running_cost);
  for (const auto& transition : phase.switching.transitions) {
    others.push_back(transition.guard);
    if (transition.reset) others.push_back(transition.reset);
  }
  return others;
}

bool any_reads(const std::vector<Function>& functions, int input) {
  return std::ranges::any_of(functions, [&](const Function& f) { return f.reads(input); });
}

bool is_bounded(const std::vector<PhaseDefinition::ComponentBounds>& bounds, int component) {
  return std::ranges::any_of(bounds, [&](const PhaseDefinition::ComponentBounds& b) {
    return b.component == component && !b.bounds.is_free();
  });
}

// True if the bounds fix the component throughout the phase.
bool is_fixed_by_bounds(const std::vector<PhaseDefinition::ComponentBounds>& bounds,
                        int component) {
  return std::ranges::any_of(bounds, [&](const PhaseDefinition::ComponentBounds& b) {
    return b.component == component && b.bounds.is_equality() && b.window.is_whole();
  });
}

class Warnings {
 public:
  explicit Warnings(const OptimalControlProblem& problem) : problem_(problem) {
    free_times_ = problem.start_time_bounds().has_value();
    for (const PhaseDefinition& phase : problem.phases())
      free_times_ = free_times_ || phase.has_free_duration();
  }

  std::vector<std::string> all() {
    for (std::size_t j = 0; j < problem_.phases().size(); ++j) {
      const PhaseDefinition& phase = problem_.phases()[j];
      check_dynamics_warnings(phase);
      for (const Term& term : phase.terms) {
        check_term_warnings(phase, term);
        check_small_values(phase, term);
      }
      check_unused_inputs(phase);
    }
    check_unused_states();
    check_unused_parameters();
    check_free_duration_cost();
    return std::move(found_);
  }

 private:
  template <class... Args>
  void add(fmt::format_string<Args...> text, Args&&... args) {
    found_.push_back(fmt::format(text, std::forward<Args>(args)...));
  }

  // True if the function depends on decisions of the solver. Time counts if durations are free.
  bool reads_decisions(const PhaseDefinition& phase, const Function& f) const {
    const Arguments& a = phase.sizes;
    if (reads_any(f, a.x(), a.nx) || reads_any(f, a.u(), a.nu)) return true;
    if (free_times_ && f.reads(a.t())) return true;
    int p = a.p();
    for (const PhaseDefinition::ParameterBlock& block : phase.parameters) {
      const int size = static_cast<int>(block.value.size());
      if (block.unknown && reads_any(f, p, size)) return true;
      p += size;
    }
    return false;
  }

  void check_dynamics_warnings(const PhaseDefinition& phase) {
    const Arguments& a = phase.sizes;
    if (!phase.switching.empty() || a.nx == 0) return;
    if (!reads_any(phase.dynamics, a.x(), a.nx + a.nu + a.np))
      add("phase '{}': the dynamics do not depend on x, u or p", phase.name);
  }

  void check_term_warnings(const PhaseDefinition& phase, const Term& term) {
    if (reads_decisions(phase, term.function)) return;
    const auto where = fmt::format("phase '{}', term '{}'", phase.name, term.name);
    if (term.kind == Term::Kind::constraint) {
      add("{}: it depends on no state, input or unknown, so no trajectory can influence it", where);
      return;
    }
    // The integral of a constant minimises time if the duration is free.
    const bool is_zero = is_constant_zero(term.function);
    if (!is_zero && term.domain == Term::Domain::running && free_times_) return;
    if (is_zero)
      add("{}: this cost is zero for every trajectory (a quotient of integers such as 1 / 2 is 0: "
          "write 0.5)",
          where);
    else
      add("{}: this cost is the same for every trajectory, because it depends on no state, input "
          "or unknown",
          where);
  }

  // A value within the default tolerance of zero is met by any trajectory that stays near zero.
  void check_small_values(const PhaseDefinition& phase, const Term& term) {
    const bool is_judged = term.kind == Term::Kind::constraint && !term.soft;
    if (!is_judged || phase.has_nominal ||
        std::ranges::find(phase.allowances, term.name, &PhaseDefinition::Allowance::term) !=
            phase.allowances.end())
      return;
    for (std::size_t i = 0; i < term.bounds.size(); ++i) {
      const Bounds& b = term.bounds[i];
      if (!b.is_equality() || b.lower == 0.0 || std::abs(b.lower) > bound_tolerance(b.lower))
        continue;
      add("phase '{}', term '{}': row {} must equal {:g}, but its tolerance is {:g}: use other "
          "units, or declare the nominal magnitude",
          phase.name, term.name, i, b.lower, bound_tolerance(b.lower));
    }
  }

  // A duration that inputs can stretch at no cost is arbitrary.
  void check_free_duration_cost() {
    const PhaseDefinition* undecided = nullptr;
    for (const PhaseDefinition& phase : problem_.phases()) {
      if (phase.input_change_weight.size() > 0) return;
      for (const Term& term : phase.terms)
        if (term.kind != Term::Kind::constraint || term.soft) return;
      for (const IntegralConstraint& integral : phase.integrals)
        if (integral.limits.soft) return;
      if (phase.has_free_duration() && phase.sizes.nu > 0 && phase.end_guards.empty() && !undecided)
        undecided = &phase;
    }
    for (const Link& link : problem_.links())
      if (link.limits.soft || link.is_cost) return;
    if (undecided)
      add("there is no cost, so the duration of phase '{}' is arbitrary within the constraints",
          undecided->name);
  }

  static bool is_constant_zero(const Function& f) {
    for (int i = 0; i < f.inputs(); ++i)
      if (f.reads(i)) return false;
    return f(VectorXd::Zero(f.inputs())).isZero(0.0);
  }

  void check_unused_inputs(const PhaseDefinition& phase) {
    const Arguments& a = phase.sizes;
    const std::vector<Function> fields = fields_of(phase), others = non_dynamics_functions(phase);
    for (int i = 0; i < a.nu; ++i) {
      const bool changes_cost =
          phase.input_change_weight.size() == a.nu && phase.input_change_weight[i] != 0.0;
      if (any_reads(fields, a.u(i)) || any_reads(others, a.u(i)) || changes_cost ||
          is_fixed_by_bounds(phase.input_bounds, i))
        continue;
      add("phase '{}': nothing depends on input {}, neither the dynamics nor a term", phase.name,
          i);
    }
  }

  // A state may be unused in one phase. A state unused in all phases is suspicious.
  void check_unused_states() {
    std::set<int> used;
    const PhaseDefinition* longest = nullptr;
    for (std::size_t j = 0; j < problem_.phases().size(); ++j) {
      const PhaseDefinition& phase = problem_.phases()[j];
      if (!longest || phase.sizes.nx > longest->sizes.nx) longest = &phase;
      const std::vector<Function> fields = fields_of(phase), others = non_dynamics_functions(phase);
      const Function* exit = nullptr;
      if (j + 1 < problem_.phases().size()) exit = &problem_.jumps()[j + 1].map;
      for (int i = 0; i < phase.sizes.nx; ++i)
        if (is_used(phase, fields, others, i) || phase.switching.memory == i ||
            (exit && *exit && reads_through(*exit, phase, i)) || is_linked(phase, 2 + i))
          used.insert(i);
    }
    if (!longest || problem_.closing()) return;
    for (int i = 0; i < longest->sizes.nx; ++i)
      if (!used.contains(i))
        add("phase '{}': nothing depends on state {}: no term, no bound and no other state",
            longest->name, i);
  }

  static bool is_used(const PhaseDefinition& phase, const std::vector<Function>& fields,
                      const std::vector<Function>& others, int i) {
    const int z = phase.sizes.x(i);
    if (any_reads(others, z) || is_bounded(phase.state_bounds, i)) return true;
    for (const Function& field : fields)
      for (int row = 0; row < field.outputs(); ++row)
        if (row != i && field.jacobian_pattern().contains(row, z)) return true;
    return false;
  }

  // True if a link reads entry i of (t | duration | x | p) at an end of the phase.
  bool is_linked(const PhaseDefinition& phase, int i) const {
    for (const Link& link : problem_.links()) {
      int first = 1;
      for (const Link::End& end : link.ends) {
        if (end.phase == phase.name && link.function.reads(first + i)) return true;
        first += end.size();
      }
    }
    return false;
  }

  // True if the state after the jump depends on state i before it.
  static bool reads_through(const Function& jump, const PhaseDefinition& phase, int i) {
    for (int row = 0; row < jump.outputs(); ++row)
      if (row != i && jump.jacobian_pattern().contains(row, phase.sizes.x(i))) return true;
    return false;
  }

  // Blocks of the same name are one parameter: it suffices that one phase reads them.
  void check_unused_parameters() {
    std::set<std::string> read, told;
    for (std::size_t j = 0; j < problem_.phases().size(); ++j) {
      const PhaseDefinition& phase = problem_.phases()[j];
      std::vector<Function> functions = fields_of(phase);
      for (Function& f : non_dynamics_functions(phase)) functions.push_back(std::move(f));
      const Function* exit = nullptr;
      if (j + 1 < problem_.phases().size())
        exit = &problem_.jumps()[j + 1].map;
      else if (problem_.closing())
        exit = &problem_.closing()->map;
      int p = 0;
      for (const PhaseDefinition::ParameterBlock& block : phase.parameters) {
        for (int i = p; i < p + block.value.size(); ++i) {
          const int in_jump = 1 + phase.sizes.nx + i;  // z = (t | x- | p)
          if (any_reads(functions, phase.sizes.p(i)) || is_linked(phase, 2 + phase.sizes.nx + i) ||
              (exit && *exit && in_jump < exit->inputs() && exit->reads(in_jump)))
            read.insert(block.name);
        }
        p += static_cast<int>(block.value.size());
      }
    }
    for (const PhaseDefinition& phase : problem_.phases())
      for (const PhaseDefinition::ParameterBlock& block : phase.parameters)
        if (block.value.size() > 0 && !read.contains(block.name) && told.insert(block.name).second)
          add("phase '{}': no formula reads parameter '{}'", phase.name, block.name);
  }

  const OptimalControlProblem& problem_;
  bool free_times_ = false;
  std::vector<std::string> found_;
};

}  // namespace

std::vector<std::string> OptimalControlProblem::warnings() const { return Warnings(*this).all(); }

}  // namespace saltus
