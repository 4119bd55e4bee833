#include "saltus/sequences/mode_graph.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <limits>
#include <memory>

#include "saltus/core/error.hpp"
#include "saltus/model/make_function.hpp"

namespace saltus {
namespace {

// A formula of (t | x) as a function of (t | x | u | p) that ignores u and p.
class Widened final : public FunctionBody {
 public:
  Widened(Function formula, int inputs)
      : FunctionBody(inputs, formula.outputs()), formula_(std::move(formula)) {
    std::vector<std::pair<int, int>> jacobian, hessian;
    formula_.jacobian_pattern().for_each([&](int r, int c, int) { jacobian.emplace_back(r, c); });
    formula_.hessian_pattern().for_each([&](int r, int c, int) { hessian.emplace_back(r, c); });
    jacobian_pattern_ = SparsityPattern::from_pairs(outputs(), inputs, jacobian);
    hessian_pattern_ = SparsityPattern::from_pairs(inputs, inputs, hessian);
  }
  int degree(int output, const std::vector<char>& variable) const override {
    return formula_.degree(output, {variable.begin(), variable.begin() + formula_.inputs()});
  }
  bool reads(int input) const override {
    return input < formula_.inputs() && formula_.reads(input);
  }
  bool is_reentrant() const override { return formula_.is_reentrant(); }
  std::shared_ptr<const FunctionBody> separate() const override {
    const Function own = formula_.separate();
    return own ? std::make_shared<Widened>(own, inputs()) : nullptr;
  }
  void value(const double* z, double* y) const override { formula_.value(z, y); }
  void jacobian(const double* z, double* y, double* entries) const override {
    formula_.jacobian(z, y, entries);
  }
  void hessian(const double* z, const double* weights, double* entries,
               Curvature curvature) const override {
    formula_.hessian(z, weights, entries, curvature);
  }

 private:
  Function formula_;
};

Function widened(const Function& formula, int inputs) {
  return Function(std::unique_ptr<const FunctionBody>(std::make_unique<Widened>(formula, inputs)));
}

bool contains(const std::vector<std::string>& names, const std::string& name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

}  // namespace

ModeGraph::ModeGraph(std::string name) : name_(std::move(name)) {}

ModeGraph& ModeGraph::transition(std::string from, std::string to, Jump jump) {
  transitions_.push_back({std::move(from), std::move(to), std::move(jump)});
  return *this;
}

ModeGraph& ModeGraph::transition_when(std::string from, std::string to, std::string event,
                                      Function guard, Crossing crossing, Jump jump) {
  transitions_.push_back({std::move(from), std::move(to), std::move(jump), std::move(event),
                          std::move(guard), crossing});
  return *this;
}

ModeGraph& ModeGraph::all_transitions() {
  all_ = true;
  return *this;
}

ModeGraph& ModeGraph::no_transition(std::string from, std::string to) {
  excluded_.emplace(std::move(from), std::move(to));
  return *this;
}

ModeGraph& ModeGraph::begin_in(std::vector<std::string> modes) {
  begin_ = std::move(modes);
  return *this;
}

ModeGraph& ModeGraph::end_in(std::vector<std::string> modes) {
  end_ = std::move(modes);
  return *this;
}

ModeGraph& ModeGraph::dwell(std::string mode, int phases) {
  dwell_[std::move(mode)] = phases;
  return *this;
}

ModeGraph& ModeGraph::enter_at_most(std::string mode, int times) {
  entries_[std::move(mode)] = times;
  return *this;
}

ModeGraph& ModeGraph::start_at(VectorXd state) {
  start_ = std::move(state);
  return *this;
}

ModeGraph& ModeGraph::start_at(std::initializer_list<double> state) {
  return start_at(VectorXd(Eigen::Map<const VectorXd>(std::data(state), std::ssize(state))));
}

ModeGraph& ModeGraph::start_time(double t) {
  start_time_ = t;
  return *this;
}

ModeGraph& ModeGraph::total_time(Bounds bounds) {
  total_time_ = bounds;
  return *this;
}

ModeGraph& ModeGraph::costs(CostRule rule) {
  cost_rule_ = rule;
  return *this;
}

ModeGraph& ModeGraph::at_end(std::string name, Function formula, Term::Kind kind, Bounds bounds) {
  end_terms_.push_back({std::move(name), std::move(formula), kind, bounds});
  return *this;
}

int ModeGraph::number_of(std::string_view mode) const {
  for (int i = 0; i < size(); ++i)
    if (modes_[i].name == mode) return i;
  std::vector<std::string> names;
  for (const PhaseDefinition& m : modes_) names.push_back("'" + m.name + "'");
  throw DefinitionError(fmt::format("modes '{}': there is no mode '{}'; the modes are {}", name_,
                                    mode, fmt::join(names, ", ")));
}

const PhaseDefinition& ModeGraph::mode(int i) const {
  if (i < 0 || i >= size())
    throw DefinitionError(
        fmt::format("modes '{}': it has {} modes, so there is no mode {}", name_, size(), i));
  return modes_[i];
}

const ModeGraph::Transition* ModeGraph::find(int from, int to) const {
  const std::string &first = mode(from).name, &second = mode(to).name;
  for (const Transition& t : transitions_)
    if (t.from == first && t.to == second) return &t;
  return nullptr;
}

bool ModeGraph::may_follow(int from, int to) const {
  return !excluded_.contains({mode(from).name, mode(to).name}) &&
         (all_ || find(from, to) != nullptr);
}

bool ModeGraph::may_begin(int i) const {
  const std::string& name = mode(i).name;
  return begin_.empty() || contains(begin_, name);
}

bool ModeGraph::may_end(int i) const {
  const std::string& name = mode(i).name;
  return end_.empty() || contains(end_, name);
}

bool ModeGraph::has_event(int from, int to) const {
  const Transition* t = find(from, to);
  return t != nullptr && (t->jump.map || t->guard);
}

int ModeGraph::min_dwell(int i) const {
  const auto it = dwell_.find(mode(i).name);
  return it == dwell_.end() ? 1 : it->second;
}

int ModeGraph::entries_of(int i) const {
  const auto it = entries_.find(mode(i).name);
  return it == entries_.end() ? std::numeric_limits<int>::max() : it->second;
}

bool ModeGraph::may_append(std::span<const int> path, int mode, ModeGraph::History before) const {
  const int length = static_cast<int>(path.size());
  const int last = length > 0 ? path.back() : before.mode;
  if (last < 0 ? !may_begin(mode) : !may_follow(last, mode)) return false;
  if (last >= 0 && mode != last) {
    int lasted = 0;
    while (lasted < length && path[length - 1 - lasted] == last) ++lasted;
    if (lasted == length && last == before.mode) lasted += before.phases;
    if (lasted < min_dwell(last)) return false;
  }
  if (entries_.empty() || mode == last) return true;
  int entries = 1;
  for (int k = 0; k < length; ++k)
    entries += path[k] == mode && (k == 0 ? before.mode != mode : path[k - 1] != mode) ? 1 : 0;
  return entries <= entries_of(mode);
}

std::vector<std::string> ModeGraph::names_of(std::span<const int> path) const {
  std::vector<std::string> names;
  for (const int i : path) names.push_back(mode(i).name);
  return names;
}

// --- problems ------------------------------------------------------------------------------------

PhaseDefinition ModeGraph::with_end(PhaseDefinition phase) const {
  for (const EndTerm& term : end_terms_) {
    if (term.formula.inputs() != 1 + phase.sizes.nx)
      throw DefinitionError(
          fmt::format("modes '{}': '{}' applies at the end and reads {} states, but mode '{}', "
                      "which may be the last, has {}",
                      name_, term.name, term.formula.inputs() - 1, phase.name, phase.sizes.nx));
    Function wide = widened(term.formula, phase.sizes.size());
    if (term.kind == Term::Kind::cost)
      add_cost(phase, std::string(term.name), Term::Domain::phase_end, std::move(wide), {});
    else
      add_constraint(phase, std::string(term.name), Term::Domain::phase_end, std::move(wide),
                     {term.bounds}, {}, std::nullopt);
  }
  return phase;
}

// Adds the guard of the transition that ends the phase.
PhaseDefinition ModeGraph::with_exit_guard(PhaseDefinition phase, const Transition* exit) const {
  if (exit == nullptr || !exit->guard) return phase;
  if (exit->guard.inputs() != 1 + phase.sizes.nx)
    throw DefinitionError(fmt::format(
        "the transition from '{}' to '{}': the guard of event '{}' reads {} states, but mode '{}' "
        "has {}",
        exit->from, exit->to, exit->event, exit->guard.inputs() - 1, exit->from, phase.sizes.nx));
  add_end_guard(phase, std::string(exit->event), widened(exit->guard, phase.sizes.size()),
                exit->crossing);
  return phase;
}

OptimalControlProblem ModeGraph::begin() const {
  OptimalControlProblem ocp(name_);
  ocp.start_at(start_).start_time(start_time_).costs(cost_rule_);
  return ocp;
}

OptimalControlProblem ModeGraph::problem(std::span<const int> path) const {
  return problem(path, [](int, PhaseDefinition&) {});
}

OptimalControlProblem ModeGraph::problem(std::span<const int> path,
                                         const std::function<void(int, PhaseDefinition&)>& edited,
                                         bool is_prefix) const {
  OptimalControlProblem ocp = begin();
  if (total_time_ && !is_prefix) ocp.total_time(*total_time_);
  for (std::size_t k = 0; k < path.size(); ++k) {
    const bool is_last = k + 1 == path.size();
    PhaseDefinition phase =
        with_exit_guard(mode(path[k]), is_last ? nullptr : find(path[k], path[k + 1]));
    if (is_last && !is_prefix) phase = with_end(std::move(phase));
    phase.name = fmt::format("{} {}", phase.name, k + 1);
    edited(static_cast<int>(k), phase);
    const Transition* entry = k > 0 ? find(path[k - 1], path[k]) : nullptr;
    ocp.then(ErasedPhase(std::move(phase)), entry != nullptr ? entry->jump : Jump{});
  }
  return ocp;
}

OptimalControlProblem ModeGraph::problem_of(int i, bool with) const {
  OptimalControlProblem ocp = begin();
  ocp.then(ErasedPhase(with ? with_end(mode(i)) : mode(i)));
  return ocp;
}

bool ModeGraph::end_reads_time() const {
  return std::any_of(end_terms_.begin(), end_terms_.end(),
                     [](const EndTerm& term) { return term.formula.reads(0); });
}

OptimalControlProblem ModeGraph::end_problem(int i, double begin_time) const {
  PhaseDefinition bare = mode(i);
  bare.terms.clear();
  bare.state_bounds.clear();
  bare.input_bounds.clear();
  bare.end_guards.clear();
  bare.input_change_weight.resize(0);
  OptimalControlProblem ocp = begin();
  ocp.start_time(begin_time).then(ErasedPhase(with_end(std::move(bare))));
  return ocp;
}

// --- checks --------------------------------------------------------------------------------------

void ModeGraph::check_names() const {
  if (modes_.empty())
    throw DefinitionError(fmt::format("modes '{}': there is no mode; add one with mode()", name_));
  std::set<std::string> seen;
  for (const PhaseDefinition& mode : modes_)
    if (!seen.insert(mode.name).second)
      throw DefinitionError(fmt::format("modes '{}': two modes are called '{}'", name_, mode.name));
  for (const Transition& t : transitions_) number_of(t.from), number_of(t.to);
  for (const auto& [from, to] : excluded_) number_of(from), number_of(to);
  for (const std::string& mode : begin_) number_of(mode);
  for (const std::string& mode : end_) number_of(mode);
  for (const auto& [mode, phases] : dwell_) {
    const int i = number_of(mode);
    if (phases > 1 && !may_follow(i, i))
      throw DefinitionError(
          fmt::format("mode '{}' has a dwell time of {} phases, but no transition to itself; add "
                      "transition(\"{}\", \"{}\")",
                      mode, phases, mode, mode));
  }
  for (const auto& [mode, times] : entries_) {
    number_of(mode);
    if (times < 0 || (times == 0 && contains(begin_, mode)))
      throw DefinitionError(fmt::format("mode '{}' has the maximum number of entries {}{}", mode,
                                        times,
                                        times < 0 ? ", expected a number that is not negative"
                                                  : ", but the sequence may begin in it"));
  }
}

void ModeGraph::check_transitions() const {
  for (std::size_t i = 0; i < transitions_.size(); ++i) {
    const Transition& t = transitions_[i];
    for (std::size_t j = 0; j < i; ++j)
      if (transitions_[j].from == t.from && transitions_[j].to == t.to)
        throw DefinitionError(
            fmt::format("the transition from '{}' to '{}' is declared twice, with the jumps '{}' "
                        "and '{}'; keep one of them",
                        t.from, t.to, transitions_[j].jump.name, t.jump.name));
    if (excluded_.contains({t.from, t.to}))
      throw DefinitionError(
          fmt::format("the transition from '{}' to '{}' is declared and excluded; remove "
                      "transition() or no_transition()",
                      t.from, t.to));
  }
  for (const auto& [from, to] : excluded_)
    if (!all_)
      throw DefinitionError(
          fmt::format("the transition from '{}' to '{}' is excluded, but nothing allows it: "
                      "no_transition() only removes from all_transitions()",
                      from, to));
}

void ModeGraph::check_reachability() const {
  const auto flood = [&](auto&& is_source, auto&& edge) {
    std::vector<char> reached(size(), 0);
    std::vector<int> open;
    for (int i = 0; i < size(); ++i)
      if (is_source(i)) reached[i] = 1, open.push_back(i);
    while (!open.empty()) {
      const int i = open.back();
      open.pop_back();
      for (int j = 0; j < size(); ++j)
        if (!reached[j] && edge(i, j)) reached[j] = 1, open.push_back(j);
    }
    return reached;
  };
  const auto forward =
      flood([&](int i) { return may_begin(i); }, [&](int i, int j) { return may_follow(i, j); });
  const auto backward =
      flood([&](int i) { return may_end(i); }, [&](int i, int j) { return may_follow(j, i); });
  for (int i = 0; i < size(); ++i) {
    if (!forward[i])
      throw DefinitionError(
          fmt::format("mode '{}': it cannot be reached from the modes in which the sequence may "
                      "begin ('{}'); add a transition or name it in begin_in()",
                      modes_[i].name, fmt::join(begin_, "', '")));
    if (!backward[i])
      throw DefinitionError(
          fmt::format("mode '{}': it cannot reach a mode in which the sequence may end ('{}'); add "
                      "a transition or name it in end_in()",
                      modes_[i].name, fmt::join(end_, "', '")));
  }
}

// Finds a cycle of modes without minimum duration and without limited entries.
void ModeGraph::check_zeno() const {
  std::vector<int> state(size(), 0), trail;
  std::function<void(int)> visit = [&](int i) {
    state[i] = 1;
    trail.push_back(i);
    for (int j = 0; j < size(); ++j) {
      if (!may_follow(i, j) || modes_[j].duration.lower > 0.0 || entries_.contains(modes_[j].name))
        continue;
      if (state[j] == 1) {
        std::vector<std::string> cycle =
            names_of({std::find(trail.begin(), trail.end(), j), trail.end()});
        cycle.push_back(modes_[j].name);
        throw DefinitionError(fmt::format(
            "modes '{}' can repeat forever in zero time (Zeno); give one of them a minimum "
            "duration, limit it with enter_at_most(), or limit the search with at_most",
            fmt::join(cycle, "' -> '")));
      }
      if (state[j] == 0) visit(j);
    }
    trail.pop_back();
    state[i] = 2;
  };
  for (int i = 0; i < size(); ++i)
    if (state[i] == 0 && modes_[i].duration.lower == 0.0 && !entries_.contains(modes_[i].name))
      visit(i);
}

void ModeGraph::check(bool limited_phases) const {
  check_names();
  check_transitions();
  check_reachability();
  if (!limited_phases) check_zeno();
  // Check phases, jumps and sizes, with the error messages of the problems that they form.
  for (int i = 0; i < size(); ++i) {
    if (!may_begin(i)) continue;
    if (start_.size() != modes_[i].sizes.nx)
      throw DefinitionError(
          fmt::format("modes '{}': the start has {} states, but mode '{}', in which the sequence "
                      "may begin, has {}",
                      name_, start_.size(), modes_[i].name, modes_[i].sizes.nx));
  }
  for (int i = 0; i < size(); ++i) {
    OptimalControlProblem alone(name_);
    alone.start_at(VectorXd(VectorXd::Zero(modes_[i].sizes.nx)))
        .then(ErasedPhase(may_end(i) ? with_end(modes_[i]) : modes_[i]))
        .check();
    for (int j = 0; j < size(); ++j) {
      if (!may_follow(i, j)) continue;
      const Transition* entry = find(i, j);
      OptimalControlProblem pair(name_);
      pair.start_at(VectorXd(VectorXd::Zero(modes_[i].sizes.nx)))
          .start_time(at_least(start_time_), start_time_)  // any phase of the sequence
          .then(ErasedPhase(with_exit_guard(modes_[i], entry)))
          .then(ErasedPhase(modes_[j]), entry != nullptr ? entry->jump : Jump{})
          .check();
    }
  }
}

}  // namespace saltus
