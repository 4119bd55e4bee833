// The optimal control problem: a start, phases in order, the jumps between them, a schedule.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "saltus/ocp/jump.hpp"
#include "saltus/ocp/link.hpp"
#include "saltus/ocp/phase.hpp"
#include "saltus/ocp/phase_definition.hpp"
#include "saltus/ocp/schedule.hpp"

namespace saltus {

/// How running costs (minimise(), track()) are accumulated over an interval. Soft constraints,
/// changes of inputs, integral constraints and costs at ends do not depend on the rule.
///
/// A sum at the nodes approximates the integral with an error of the order of an interval's length
/// (1 to 2 % with ten intervals where integrated costs are off by 0.1 %). Choose it to reproduce a
/// discrete-time problem that is defined by such a sum. Phases with linear inputs integrate under
/// either rule: the cost at the start of an interval does not depend on the input at its end.
enum class CostRule {
  integrated,  ///< Integral by the integrator, together with the dynamics. The default.
  nodes        ///< Length of the interval times the cost at its start.
};

/// One or more phases in order. Copies are independent; formulas are shared, being immutable.
class OptimalControlProblem {
 public:
  OptimalControlProblem(const OptimalControlProblem& other);
  OptimalControlProblem(OptimalControlProblem&& other) noexcept;
  OptimalControlProblem& operator=(const OptimalControlProblem& other);
  OptimalControlProblem& operator=(OptimalControlProblem&& other) noexcept;
  ~OptimalControlProblem();
  /// `name` is for messages.
  explicit OptimalControlProblem(std::string name = "problem");

  /// The state at the start is given (it can be replaced between solves).
  OptimalControlProblem& start_at(VectorXd state);
  /// The same by its numbers: start_at({0, 0}).
  OptimalControlProblem& start_at(std::initializer_list<double> state);
  /// The state at the start is free within bounds; `guess` starts the search.
  OptimalControlProblem& start_within(std::vector<Bounds> bounds, VectorXd guess);
  /// Absolute time of the start, s.
  OptimalControlProblem& start_time(double t);
  /// The time of the start is the solver's to decide within bounds; `guess` starts the search, s.
  OptimalControlProblem& start_time(Bounds bounds, double guess);

  /// Appends a copy of the phase behind what there is; its first state is that before. What the
  /// phase is told afterwards does not reach the problem.
  template <int nx, int nu, int np, int nz>
  OptimalControlProblem& then(const Phase<nx, nu, np, nz>& phase) {
    return append(Jump{}, phase.definition());
  }
  /// Enters the phase through the jump.
  template <int nx, int nu, int np, int nz>
  OptimalControlProblem& then(const Phase<nx, nu, np, nz>& phase, Jump jump) {
    return append(std::move(jump), phase.definition());
  }

  /// Closes the problem: it begins with the state with which it ends (a periodic trajectory), or
  /// with what the jump makes of it. The start may then be free (start_within()).
  OptimalControlProblem& close(Jump jump = Jump{});

  /// Keeps a formula of the ends of any phases within limits: of their states, absolute times,
  /// durations and parameters (EndValues). Its arguments are the ends in their order.
  ///
  ///     ocp.link("up twice as long as down", [](const auto& up, const auto& down) {
  ///       return up.duration - 2.0 * down.duration; }, exactly(0.0), end_of(up), end_of(down));
  template <class F, class... Ends>
  OptimalControlProblem& link(std::string name, F formula, Limits limits, Ends... ends) {
    return add_link(
        make_link(std::move(name), std::move(formula), std::move(limits), std::move(ends)...));
  }

  /// Events to which windows refer by name.
  OptimalControlProblem& schedule(Schedule schedule);
  /// Sets the rule for running costs: the integral (default) or the sum at the nodes.
  OptimalControlProblem& costs(CostRule rule);
  /// Bounds on the sum of all durations, s.
  OptimalControlProblem& total_time(Bounds bounds);

  /// The problem once its first phases are over: it begins with the state of the phase that is then
  /// the first, to be given by start_at(). Throws DefinitionError if none is left, it is closed, or
  /// an integral or a link joins what is over to what is left.
  OptimalControlProblem after(int phases) const;

  /// Sets every penalty weight of this name; false if there is none.
  bool set_penalty_weight(std::string_view weight_name, double weight);
  /// For event times that move between solves.
  Schedule& editable_schedule() { return schedule_; }
  /// For a problem that differs from another in a bound or a number: check() looks at it again.
  /// Throws DefinitionError, as all that take a number, unless there is such a phase.
  PhaseDefinition& editable_phase(int j);
  /// The same of a link.
  Link& editable_link(int i);

  /// For messages.
  const std::string& name() const { return name_; }
  /// In their order.
  const std::vector<PhaseDefinition>& phases() const { return phases_; }
  /// jumps()[j] leads into phase j; the first is never used.
  const std::vector<Jump>& jumps() const { return jumps_; }
  /// From the end of the last phase to the start of the first; empty: the problem is open.
  const std::optional<Jump>& closing() const { return closing_; }
  /// One per state of the first phase.
  const std::vector<Bounds>& start_bounds() const { return start_bounds_; }
  /// Where the search for the first state begins.
  const VectorXd& start_guess() const { return start_guess_; }
  double start_time() const { return start_time_; }  ///< s; if free, its guess
  /// Of a free start time, s; empty: the start is given.
  const std::optional<Bounds>& start_time_bounds() const { return start_time_bounds_; }
  /// Between ends of any phases.
  const std::vector<Link>& links() const { return links_; }
  /// Position of the phase of this name. Throws DefinitionError, naming the nearest one, if there
  /// is none or more than one.
  int phase_index(const std::string& phase) const;
  /// Of events and modes; may be edited between solves.
  const Schedule& schedule() const { return schedule_; }
  /// The rule for running costs that was set.
  CostRule cost_rule() const { return cost_rule_; }
  /// The rule that applies in a phase: phases with linear inputs always integrate.
  CostRule cost_rule(int phase) const;
  /// Of all durations together, s.
  Bounds total_time() const { return total_time_; }
  /// Bounds on entry i of an unknown: those of all phases that declare it.
  Bounds bounds_of_unknown(const std::string& name, int i) const;

  /// Checks every size once. Throws DefinitionError naming phase and term.
  void check() const;
  /// One sentence for each thing that is sound and yet looks like a mistake, with phase and term: a
  /// cost that is the same for every trajectory, an input, state or parameter that nothing depends
  /// on. solve() adds them to the solution. Expects that check() passes.
  std::vector<std::string> warnings() const;

 private:
  const PhaseDefinition& phase_at(int j) const;
  OptimalControlProblem& append(Jump jump, const PhaseDefinition& phase);
  OptimalControlProblem& add_link(Link&& link);
  void check_times() const;
  void check_start() const;
  void check_parameters() const;
  void check_integrals() const;
  void check_links() const;

  std::string name_;
  std::vector<PhaseDefinition> phases_;
  std::vector<Jump> jumps_;
  std::optional<Jump> closing_;
  std::vector<Bounds> start_bounds_;
  VectorXd start_guess_;
  double start_time_ = 0.0;
  std::optional<Bounds> start_time_bounds_;
  std::vector<Link> links_;
  Schedule schedule_;
  CostRule cost_rule_ = CostRule::integrated;
  Bounds total_time_;
};

}  // namespace saltus
