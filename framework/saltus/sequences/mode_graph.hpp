// A problem whose sequence of modes is not given: modes, which may follow which, and what holds at
// the end. Every path through the graph is an OptimalControlProblem.
//
//     ModeGraph thermostat{"thermostat"};
//     thermostat.mode(off).mode(on)                       // a Phase each
//         .transition("off", "on").transition("on", "off")
//         .begin_in({"off"}).start_at({18.0})
//         .total_time(exactly(3600.0));
//     const SequenceResult best = search(thermostat, {.at_most = 9});
//
// In sampled time a mode lasts one sample, a duration that is fixed, and follows itself.
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

/// A phase of which only the erased definition is left, for OptimalControlProblem::then().
template <>
class Phase<-1, -1, -1> {
 public:
  /// From what was declared.
  explicit Phase(PhaseDefinition definition) : d_(std::move(definition)) {}
  /// What was declared.
  const PhaseDefinition& definition() const { return d_; }

 private:
  PhaseDefinition d_;
};
/// A phase of any sizes.
using ErasedPhase = Phase<-1, -1, -1>;

/// A set of modes as bits.
using ModeSet = std::uint64_t;
/// The set of this one.
inline ModeSet only(int mode) { return ModeSet{1} << mode; }
/// Whether there is one mode in it.
inline bool is_single(ModeSet set) { return (set & (set - 1)) == 0; }

/// What came before a path and lasts on: its last mode, and for how many phases; -1: nothing did.
struct ModeHistory {
  int mode = -1;   ///< in force; -1: none yet
  int phases = 0;  ///< for how many phases it has been
};

/// Modes and what may follow what: the graph that is searched.
class ModeGraph {
 public:
  /// `name` is for messages.
  explicit ModeGraph(std::string name = "modes");

  // --- modes and what may follow what; names that are unknown or contradict one another are said
  // --- by check(), so that the order of these calls does not matter
  /// Appends a mode.
  template <int nx, int nu, int np, int nz>
  ModeGraph& mode(const Phase<nx, nu, np, nz>& phase) {
    modes_.push_back(phase.definition());
    return *this;
  }
  /// `to` may follow `from`, the state as it is or through a jump.
  ModeGraph& transition(std::string from, std::string to, Jump jump = Jump{});
  /// The same where the guard, a scalar of (t, x), passes zero in the given direction: it decides
  /// how long `from` lasts, whose duration is free. Where a mode is left otherwise it says nothing.
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
  /// Every mode may follow every mode, itself included, without a jump.
  ModeGraph& all_transitions();
  /// Not this one, whatever all_transitions() says.
  ModeGraph& no_transition(std::string from, std::string to);
  /// The modes that may be the first (last) one; not said: any.
  ModeGraph& begin_in(std::vector<std::string> modes);
  /// The modes that may be the last one; not said: any.
  ModeGraph& end_in(std::vector<std::string> modes);
  /// Whenever the mode is entered it follows itself until it has lasted so many phases, or to the
  /// end. In sampled time the dwell time in samples; modes of free duration have bounds for it.
  ModeGraph& dwell(std::string mode, int phases);
  /// The mode is entered at most so many times; the start counts, following itself does not.
  ModeGraph& enter_at_most(std::string mode, int times);

  // --- the rest of the problem, as in OptimalControlProblem
  /// As in OptimalControlProblem.
  ModeGraph& start_at(VectorXd state);
  /// As in OptimalControlProblem.
  ModeGraph& start_at(std::initializer_list<double> state);
  /// In s.
  ModeGraph& start_time(double t);
  /// Of all durations together, s.
  ModeGraph& total_time(Bounds bounds);
  /// Sets the rule for running costs of every mode: the integral (default) or the sum at the nodes.
  ModeGraph& costs(CostRule rule);
  /// Of (t, x), where the last mode ends, whichever it is.
  template <int nx, class F>
  ModeGraph& minimise_at_end(std::string name, F formula) {
    static_assert(ReturnsRows<F, 1, nx, 0, 0>, "a cost must return a scalar");
    return at_end(std::move(name), make_function<nx, 0, 0>(std::move(formula)), TermKind::cost, {});
  }
  /// A constraint of (t, x) where the last mode ends, whichever it is.
  template <int nx, class F>
  ModeGraph& reach_at_end(std::string name, F formula, Bounds bounds) {
    return at_end(std::move(name), make_function<nx, 0, 0>(std::move(formula)),
                  TermKind::constraint, bounds);
  }

  // --- what it is
  /// For messages.
  const std::string& name() const { return name_; }
  /// How many modes.
  int size() const { return static_cast<int>(modes_.size()); }
  /// Mode i.
  const PhaseDefinition& mode(int i) const { return modes_[i]; }
  /// The first state.
  const VectorXd& start() const { return start_; }
  double start_time() const { return start_time_; }  ///< s
  /// In s; empty: not limited.
  const std::optional<Bounds>& total_time() const { return total_time_; }
  /// Number of the mode of this name. Throws DefinitionError.
  int number_of(std::string_view mode) const;
  /// Whether there is such a transition.
  bool may_follow(int from, int to) const;
  /// Whether it may be the first one.
  bool may_begin(int mode) const;
  /// Whether it may be the last one.
  bool may_end(int mode) const;
  /// Whether the state jumps, or a guard decides when.
  bool has_event(int from, int to) const;
  /// In phases.
  int dwell_of(int mode) const;
  int entries_of(int mode) const;  ///< at most
  /// Whether any mode may be entered so many times only.
  bool limits_entries() const { return !entries_.empty(); }
  /// Whether not every mode may be the last one.
  bool limits_end() const { return !end_.empty(); }
  /// Whether a cost or constraint of the end reads the time of the end.
  bool end_reads_time() const;
  /// Whether `mode` may be appended to the path: transitions, dwell and number of entries.
  bool may_append(std::span<const int> path, int mode, ModeHistory before) const;
  /// For messages.
  std::vector<std::string> names_of(std::span<const int> path) const;

  /// The problem with this sequence. Phases are named after the mode and its place, counted from 1.
  OptimalControlProblem problem(std::span<const int> path) const;
  /// The same with phases that are `edited` first, by their place from 0. `is_beginning`: without
  /// what holds at the end and the total time.
  OptimalControlProblem problem(std::span<const int> path,
                                const std::function<void(int, PhaseDefinition&)>& edited,
                                bool is_beginning = false) const;
  /// Of one mode alone, with what holds at the end or without it.
  OptimalControlProblem problem_of(int mode, bool with_end) const;
  /// The costs and constraints of the end, and nothing else, behind a phase of this mode's size
  /// that begins at time `begin` (s): the phase that is the last of a sequence.
  OptimalControlProblem problem_of_end(int mode, double begin) const;

  /// Throws DefinitionError with the names of modes: sizes that do not fit, a mode that nothing
  /// leads to or from which no end is reached, transitions declared twice or both declared and
  /// excluded, a dwell time without a way to stay, and, where the number of phases is not limited,
  /// a cycle in which no time need pass (Zeno).
  void check(bool limited_phases) const;

 private:
  ModeGraph& transition_when(std::string from, std::string to, std::string event, Function guard,
                             Crossing crossing, Jump jump);
  ModeGraph& at_end(std::string name, Function formula, TermKind kind, Bounds bounds);
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
    Function guard = {};  // of (t | x); empty: at any time
    Crossing crossing = Crossing::falling;
  };
  PhaseDefinition left_by(PhaseDefinition phase, const Transition* exit) const;
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
    Function formula;  // of (t | x)
    TermKind kind;
    Bounds bounds;
  };
  std::vector<EndTerm> end_terms_;
  VectorXd start_;
  double start_time_ = 0.0;
  std::optional<Bounds> total_time_;
  CostRule cost_rule_ = CostRule::integrated;
};

}  // namespace saltus
