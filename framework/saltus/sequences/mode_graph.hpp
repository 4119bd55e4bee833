// A problem with a free sequence of modes: modes, allowed transitions, and conditions at the end.
// Every path through the graph is an OptimalControlProblem.
//
//     ModeGraph thermostat{"thermostat"};
//     thermostat.mode(off).mode(on)                       // a Phase each
//         .transition("off", "on").transition("on", "off")
//         .begin_in({"off"}).start_at({18.0})
//         .total_time(exactly(3600.0));
//     const SequenceResult best = search(thermostat, {.at_most = 9});
//
// In sampled time, a mode has a fixed duration of one sample and a transition to itself.
#pragma once

#include <cstdint>
#include <functional>
#include <initializer_list>
#include <map>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "saltus/ocp/problem.hpp"

namespace saltus {

/// A phase with only its erased definition, for OptimalControlProblem::then().
template <>
class Phase<-1, -1, -1> {
 public:
  /// Stores the definition.
  explicit Phase(PhaseDefinition definition) : d_(std::move(definition)) {}
  /// The definition.
  const PhaseDefinition& definition() const { return d_; }

 private:
  PhaseDefinition d_;
};
/// A phase of any size.
using ErasedPhase = Phase<-1, -1, -1>;

/// A set of modes as a bit set.
using ModeSet = std::uint64_t;
/// The set that contains only this mode.
inline ModeSet only(int mode) { return ModeSet{1} << mode; }
/// True if the set contains exactly one mode.
inline bool is_single(ModeSet set) { return (set & (set - 1)) == 0; }

/// The graph of modes and transitions that is searched.
class ModeGraph {
 public:
  /// The mode active before a path and its duration in phases. -1: none.
  struct History {
    int mode = -1;   ///< the active mode, or -1
    int phases = 0;  ///< phases since it was entered
  };

  /// `name` appears in messages.
  explicit ModeGraph(std::string name = "modes");

  // --- modes and transitions ---------------------------------------------------------------
  // The order of these calls does not matter: check() reports unknown and contradictory names.

  /// Appends a mode.
  template <int nx, int nu, int np, int nz>
  ModeGraph& mode(const Phase<nx, nu, np, nz>& phase) {
    modes_.push_back(phase.definition());
    return *this;
  }
  /// Allows `to` after `from`, with or without a jump of the state.
  ModeGraph& transition(std::string from, std::string to, Jump jump = Jump{});
  /// Allows `to` after `from` where the guard, a scalar of (t, x), crosses zero in the given
  /// direction. The guard determines the free duration of `from`. It has no effect on other
  /// transitions.
  template <int nx, class F>
  ModeGraph& transition_when(std::string from, std::string to, std::string event, F guard,
                             Crossing crossing, Jump jump = Jump{}) {
    static_assert(ReturnsRows<F, 1, nx, 0, 0>,
                  "a guard must return a scalar, which is zero at the event");
    Function function =
        make_function<nx, 0, 0>(std::move(guard), {from, "the guard of event", event});
    return transition_when(std::move(from), std::move(to), std::move(event), std::move(function),
                           crossing, std::move(jump));
  }
  /// Takes the guard as a Function of (t | x).
  ModeGraph& transition_when(std::string from, std::string to, std::string event, Function guard,
                             Crossing crossing, Jump jump = Jump{});
  /// Allows all transitions without a jump, including each mode to itself.
  ModeGraph& all_transitions();
  /// Excludes a transition, also after all_transitions().
  ModeGraph& no_transition(std::string from, std::string to);
  /// Modes that may be the first one. Default: any.
  ModeGraph& begin_in(std::vector<std::string> modes);
  /// Modes that may be the last one. Default: any.
  ModeGraph& end_in(std::vector<std::string> modes);
  /// Minimum number of phases of the mode after each entry, unless the sequence ends first. In
  /// sampled time this is the dwell time in samples. For modes of free duration, use bounds on the
  /// duration.
  ModeGraph& dwell(std::string mode, int phases);
  /// Maximum number of entries into the mode. Starting in it counts, a transition to itself does
  /// not.
  ModeGraph& enter_at_most(std::string mode, int times);

  // --- other parts of the problem, as in OptimalControlProblem
  /// Fixes the state at the start.
  ModeGraph& start_at(VectorXd state);
  /// Fixes the state at the start by its entries.
  ModeGraph& start_at(std::initializer_list<double> state);
  /// Sets the absolute start time, s.
  ModeGraph& start_time(double t);
  /// Bounds the sum of all durations, s.
  ModeGraph& total_time(Bounds bounds);
  /// Sets the rule for running costs of all modes. Default: the integral.
  ModeGraph& costs(CostRule rule);
  /// Adds a cost of (t, x) at the end of the last mode, whichever it is.
  template <int nx, class F>
  ModeGraph& minimise_at_end(std::string name, F formula) {
    static_assert(ReturnsRows<F, 1, nx, 0, 0>, "a cost must return a scalar");
    return minimise_at_end(std::move(name), make_function<nx, 0, 0>(std::move(formula)));
  }
  /// Takes the cost as a Function of (t | x).
  ModeGraph& minimise_at_end(std::string name, Function formula) {
    return at_end(std::move(name), std::move(formula), Term::Kind::cost, {});
  }
  /// Adds a constraint of (t, x) at the end of the last mode, whichever it is.
  template <int nx, class F>
  ModeGraph& reach_at_end(std::string name, F formula, Bounds bounds) {
    return reach_at_end(std::move(name), make_function<nx, 0, 0>(std::move(formula)), bounds);
  }
  /// Takes the constraint as a Function of (t | x).
  ModeGraph& reach_at_end(std::string name, Function formula, Bounds bounds) {
    return at_end(std::move(name), std::move(formula), Term::Kind::constraint, bounds);
  }

  // --- queries
  /// Name for messages.
  const std::string& name() const { return name_; }
  /// Number of modes.
  int size() const { return static_cast<int>(modes_.size()); }
  /// Mode i. Throws DefinitionError if there is no such mode, like all members that take an index.
  const PhaseDefinition& mode(int i) const;
  /// The state at the start.
  const VectorXd& start() const { return start_; }
  double start_time() const { return start_time_; }  ///< s
  /// Bounds of the total time, s. Empty: none.
  const std::optional<Bounds>& total_time() const { return total_time_; }
  /// Index of the mode with this name. Throws DefinitionError if there is none.
  int number_of(std::string_view mode) const;
  /// True if the transition is allowed.
  bool may_follow(int from, int to) const;
  /// True if the mode may be the first one.
  bool may_begin(int i) const;
  /// True if the mode may be the last one.
  bool may_end(int i) const;
  /// True if the transition has a jump or a guard.
  bool has_event(int from, int to) const;
  /// Minimum dwell in phases.
  int min_dwell(int i) const;
  /// Deprecated name.
  [[deprecated("use min_dwell; removed in 0.4")]] int dwell_of(int i) const { return min_dwell(i); }
  int entries_of(int i) const;  ///< maximum number of entries
  /// True if a mode has a maximum number of entries.
  bool limits_entries() const { return !entries_.empty(); }
  /// True if some mode may not be the last one.
  bool limits_end() const { return !end_.empty(); }
  /// True if a cost or constraint at the end depends on the end time.
  bool end_reads_time() const;
  /// True if transitions, dwell and number of entries allow `mode` after the path.
  bool may_append(std::span<const int> path, int mode, History before) const;
  /// Names of the modes of a path, for messages.
  std::vector<std::string> names_of(std::span<const int> path) const;

  /// The problem of this sequence. Each phase is named after its mode and its position from 1.
  OptimalControlProblem problem(std::span<const int> path) const;
  /// The same after `edited` has changed the phases, which it receives with their positions from 0.
  /// With `is_prefix`, omits conditions at the end and the total time.
  OptimalControlProblem problem(std::span<const int> path,
                                const std::function<void(int, PhaseDefinition&)>& edited,
                                bool is_prefix = false) const;
  /// The problem of a single mode, with or without the conditions at the end.
  OptimalControlProblem problem_of(int i, bool with_end) const;
  /// Only the costs and constraints at the end, after a phase of this mode's size that begins at
  /// time `begin` (s). This phase is the last one of a sequence.
  OptimalControlProblem end_problem(int i, double begin) const;
  /// Deprecated name.
  [[deprecated("use end_problem; removed in 0.4")]] OptimalControlProblem problem_of_end(
      int i, double begin) const {
    return end_problem(i, begin);
  }

  /// Throws DefinitionError with the names of modes if the graph is invalid. It checks sizes,
  /// unreachable modes, modes without a path to an end, and contradictory transitions. It also
  /// checks dwell times without a transition to the mode itself. With an unlimited number of
  /// phases, it rejects cycles without a minimum duration (Zeno).
  void check(bool limited_phases) const;

 private:
  ModeGraph& at_end(std::string name, Function formula, Term::Kind kind, Bounds bounds);
  PhaseDefinition with_end(PhaseDefinition phase) const;
  OptimalControlProblem begin() const;
  void check_names() const;
  void check_transitions() const;
  void check_reachability() const;
  void check_zeno() const;

  struct Transition {
    std::string from, to;
    Jump jump;
    std::string event = {};
    Function guard = {};  // function of (t | x); empty: any time
    Crossing crossing = Crossing::falling;
  };
  PhaseDefinition with_exit_guard(PhaseDefinition phase, const Transition* exit) const;
  const Transition* find(int from, int to) const;

  std::string name_;
  std::vector<PhaseDefinition> modes_;
  std::vector<Transition> transitions_;
  std::set<std::pair<std::string, std::string>> excluded_;
  bool all_ = false;
  std::vector<std::string> begin_, end_;
  std::map<std::string, int> dwell_, entries_;
  struct EndTerm {
    std::string name;
    Function formula;  // function of (t | x)
    Term::Kind kind;
    Bounds bounds;
  };
  std::vector<EndTerm> end_terms_;
  VectorXd start_;
  double start_time_ = 0.0;
  std::optional<Bounds> total_time_;
  CostRule cost_rule_ = CostRule::integrated;
};

}  // namespace saltus
