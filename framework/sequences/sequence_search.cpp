#include "saltus/sequences/sequence_search.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/qp/riccati_solver.hpp"
#include "saltus/sequences/mode_stages.hpp"
#include "saltus/solver/sqp.hpp"

namespace saltus {
namespace {

// All shares of a relaxed solution this near to 0 or 1: the sequence is tried at once.
constexpr double nearly_integral = 1e-3;
// More leaves than this are not worth their tails: the next tick starts anew.
constexpr std::size_t most_leaves = 5000;

std::unique_ptr<StageQpSolver> solver_for(const StageQp& capacity, double tolerance) {
  RiccatiOptions options;
  options.tolerance = tolerance;
  return make_riccati_solver(capacity, options);
}

ModeGraph checked(ModeGraph graph, const SearchOptions& options) {
  if (options.phases < 1)
    throw DefinitionError(
        fmt::format("modes '{}': the horizon has {} phases; say how many by SearchOptions::phases",
                    graph.name(), options.phases));
  if (!(options.gap >= 0.0) || !(options.tolerance > 0.0) || !(options.deadline > 0.0))
    throw DefinitionError("search: the gap must not be negative, tolerance and deadline positive");
  graph.check(true);
  return graph;
}

}  // namespace

SequenceSearch::SequenceSearch(ModeGraph graph, SearchOptions options)
    : graph_(checked(std::move(graph), options)),
      options_(std::move(options)),
      stages_(std::make_unique<ModeStages>(
          graph_, options_.integrator ? options_.integrator : zero_order_hold())) {
  if (!stages_->reason().empty())
    throw DefinitionError(fmt::format("modes '{}': no convex problem in sampled time: {}",
                                      graph_.name(), stages_->reason()));
  qp_ = stages_->capacity(options_.phases, true);
  solver_ = solver_for(qp_, options_.tolerance);
  point_ = StagePoint(qp_);
  tail_qp_ = stages_->capacity(1, false);
  tail_solver_ = solver_for(tail_qp_, options_.tolerance);
  tail_point_ = StagePoint(tail_qp_);
  qp_.stages.back() = tail_qp_.stages.back() = stages_->end();
  filled_.assign(options_.phases, 0);
}

SequenceSearch::SequenceSearch(SequenceSearch&&) noexcept = default;
SequenceSearch& SequenceSearch::operator=(SequenceSearch&&) noexcept = default;
SequenceSearch::~SequenceSearch() = default;

// Which modes every phase may have: those that transitions lead to, from the path and back from the
// end. Dwell times and numbers of entries are left out, which relaxes.
std::vector<ModeSet> SequenceSearch::sets_of(const std::vector<int>& path) const {
  const int N = options_.phases, fixed = static_cast<int>(path.size());
  std::vector<ModeSet> sets(N, 0);
  for (int k = 0; k < N; ++k)
    for (int i = 0; i < graph_.size(); ++i) {
      bool may = k < fixed ? path[k] == i : k > 0;
      if (k == 0 && fixed == 0)
        may = graph_.may_append({}, i, before_) && stages_->admits(i, start_);
      if (k > 0 && may) {
        may = false;
        for (int j = 0; j < graph_.size(); ++j)
          may = may || ((sets[k - 1] & only(j)) != 0 && graph_.may_follow(j, i));
      }
      if (may && k == N - 1) may = graph_.may_end(i);
      if (may) sets[k] |= only(i);
    }
  for (int k = N - 2; k >= 0; --k)
    for (int i = 0; i < graph_.size(); ++i) {
      bool goes_on = false;
      for (int j = 0; j < graph_.size(); ++j)
        goes_on = goes_on || ((sets[k + 1] & only(j)) != 0 && graph_.may_follow(i, j));
      if (!goes_on) sets[k] &= ~only(i);
    }
  return sets;
}

QpResult SequenceSearch::solve_program(const std::vector<int>& path, const Node* from) {
  const std::vector<ModeSet> sets = sets_of(path);
  QpResult result;
  result.status = QpStatus::infeasible;
  for (const ModeSet set : sets)
    if (set == 0) return result;
  if (!path.empty() && !stages_->admits(path.front(), start_)) return result;
  const int N = options_.phases;
  const SetStage* before = nullptr;
  bool previous_changed = false;
  for (int k = 0; k < N; ++k) {
    const SetStage& set = stages_->of(sets[k], k == 0);
    const bool changed = filled_[k] != sets[k];
    if (changed) qp_.stages[k] = set.stage;
    if (changed || previous_changed) {
      if (before != nullptr) {
        qp_.stages[k].x_lower = set.stage.x_lower.cwiseMax(before->end_lower);
        qp_.stages[k].x_upper = set.stage.x_upper.cwiseMin(before->end_upper);
      }
    }
    filled_[k] = sets[k];
    previous_changed = changed;
    before = &set;
  }
  if (previous_changed) {
    qp_.stages[N].x_lower = stages_->end().x_lower.cwiseMax(before->end_lower);
    qp_.stages[N].x_upper = stages_->end().x_upper.cwiseMin(before->end_upper);
  }
  for (int k = 1; k <= N; ++k)  // bounds of one mode's end and the next one's start that exclude
    if ((qp_.stages[k].x_lower.array() > qp_.stages[k].x_upper.array()).any()) return result;
  qp_.start = start_;
  const bool warm = options_.warm && from != nullptr && from->point != nullptr;
  if (warm) {
    const std::vector<ModeSet> old = sets_of(from->point_path);
    for (int k = 0; k < N; ++k) {
      if (old[k] == sets[k] || old[k] == 0)
        point_.stages[k] = from->point->stages[k];
      else
        restrict_point(stages_->of(old[k], k == 0), from->point->stages[k],
                       stages_->of(sets[k], k == 0), sets[k], point_.stages[k]);
    }
    point_.stages[N] = from->point->stages[N];
  }
  const auto begin = WallClock::now();
  result = solver_->solve(qp_, point_, warm);
  if (warm && result.status != QpStatus::optimal && result.status != QpStatus::infeasible &&
      result.status != QpStatus::deadline) {
    const int before_that = result.iterations;
    result = solver_->solve(qp_, point_, false);
    result.iterations += before_that;
  }
  solver_seconds_ += seconds_since(begin);
  return result;
}

// mu of every mode of a set, by the number of the mode.
std::vector<double> SequenceSearch::shares(const SetStage& stage,
                                           const StagePoint::AtStage& point) const {
  std::vector<double> result(graph_.size(), 0.0);
  double rest = 1.0;
  for (std::size_t m = 0; m < stage.modes.size(); ++m) {
    const HullMode& mode = stage.modes[m];
    const bool is_last = m + 1 == stage.modes.size();
    const double share = is_last ? rest : point.u[mode.first + stages_->states() + mode.nu];
    result[mode.mode] = share;
    rest -= share;
  }
  return result;
}

// Whether the relaxed solution has chosen a sequence: every share is nearly 0 or 1.
bool SequenceSearch::choose(const Node& node, std::vector<int>& path) {
  const std::vector<ModeSet> sets = sets_of(node.path);
  path.clear();
  for (int k = 0; k < options_.phases; ++k) {
    int mode = std::countr_zero(sets[k]);
    if (!is_single(sets[k])) {
      const std::vector<double> share = shares(stages_->of(sets[k], k == 0), node.point->stages[k]);
      mode = static_cast<int>(std::max_element(share.begin(), share.end()) - share.begin());
      if (share[mode] < 1.0 - nearly_integral) return false;
    }
    if (!graph_.may_append(path, mode, before_)) return false;
    path.push_back(mode);
  }
  return true;
}

void SequenceSearch::accept(const std::vector<int>& path, double cost, SequenceResult& best) const {
  if (!(cost < best.cost)) return;
  best.cost = cost;
  best.modes = path;
  best.states.clear();
  best.inputs.clear();
}

// --- the search ----------------------------------------------------------------------------------

SequenceResult SequenceSearch::solve(const VectorRef& state, ModeHistory before) {
  const auto begin = WallClock::now();
  start_ = stages_->scaled(state);
  before_ = before;
  leaves_.clear();
  best_.clear();
  return run(std::vector<Node>(1), begin);
}

SequenceResult SequenceSearch::solve_next(const VectorRef& state) {
  if (best_.empty()) return solve(state);
  const int applied = best_.front();
  const ModeHistory before{applied, before_.mode == applied ? before_.phases + 1 : 1};
  if (graph_.limits_end() || graph_.limits_entries()) return solve(state, before);
  const auto begin = WallClock::now();
  start_ = stages_->scaled(state);
  std::vector<Node> open = shifted();
  before_ = before;
  const long reused = static_cast<long>(open.size());
  if (open.empty() || open.size() > most_leaves) open.assign(1, Node{});
  SequenceResult result = run(std::move(open), begin);
  result.reused = reused;
  return result;
}

SequenceResult SequenceSearch::run(std::vector<Node> open, WallClock::time_point begin) {
  SequenceResult best;
  solver_seconds_ = 0.0;
  const auto deadline = seconds_after(begin, options_.deadline);
  solver_->set_deadline(deadline);
  std::vector<Node> closed;
  std::shared_ptr<const StagePoint> best_point;
  const int N = options_.phases;
  bool stopped = false;
  double lowest_closed = infinity;  // of what was given up without being ruled out
  const auto worse = [](const Node& a, const Node& b) { return a.bound > b.bound; };
  std::make_heap(open.begin(), open.end(), worse);
  const auto cut = [&] {
    return best.cost < infinity ? best.cost - options_.gap * std::abs(best.cost) : infinity;
  };
  // Of the last tick's sequence what is left goes first: it is feasible or nearly so.
  std::vector<int> wanted =
      best_.empty() ? best_ : std::vector<int>(best_.begin() + 1, best_.end());
  std::vector<Node> dive;  // at most one: the child to go on with
  if (!wanted.empty())
    for (std::size_t i = 0; i < open.size(); ++i)
      if (open[i].path.size() >= 1 && open[i].path.size() <= wanted.size() &&
          std::equal(open[i].path.begin(), open[i].path.end(), wanted.begin()) &&
          (dive.empty() || open[i].path.size() > dive[0].path.size())) {
        if (!dive.empty())
          std::swap(dive[0], open[i]);
        else {
          dive.push_back(std::move(open[i]));
          open.erase(open.begin() + static_cast<long>(i));
          --i;
        }
      }
  std::make_heap(open.begin(), open.end(), worse);

  while (!open.empty() || !dive.empty()) {
    Node node;
    if (!dive.empty()) {
      node = std::move(dive.back());
      dive.pop_back();
    } else {
      if (open.front().bound >= cut()) break;
      std::pop_heap(open.begin(), open.end(), worse);
      node = std::move(open.back());
      open.pop_back();
    }
    if (node.bound >= cut()) {
      closed.push_back(std::move(node));
      continue;
    }
    if (WallClock::now() >= deadline || best.nodes >= options_.max_nodes) {
      stopped = true;
      open.push_back(std::move(node));
      break;
    }
    const QpResult solved = solve_program(node.path, &node);
    ++best.nodes;
    best.iterations += solved.iterations;
    if (solved.status == QpStatus::deadline) {
      stopped = true;
      open.push_back(std::move(node));
      break;
    }
    if (solved.status == QpStatus::infeasible) {
      ++best.infeasible;
      closed.push_back(std::move(node));
      continue;
    }
    const bool complete = static_cast<int>(node.path.size()) == N;
    if (solved.status != QpStatus::optimal) {
      ++best.unresolved;
      if (complete) {
        lowest_closed = std::min(lowest_closed, node.bound);
        closed.push_back(std::move(node));
        continue;
      }
      for (int i = 0; i < graph_.size(); ++i) {  // its bound stays that of what it began in
        if (!graph_.may_append(node.path, i, before_)) continue;
        Node child = node;
        child.path.push_back(i);
        open.push_back(std::move(child));
        std::push_heap(open.begin(), open.end(), worse);
      }
      continue;
    }
    node.bound = std::max(node.bound, solved.objective);
    const std::vector<ModeSet> sets = sets_of(node.path);
    node.point = std::make_shared<StagePoint>(point_);
    node.point_path = node.path;
    node.dual = dual_of(static_cast<int>(node.path.size()));
    if (complete) {
      accept(node.path, solved.objective, best);
      if (best.modes == node.path) best_point = node.point;
      closed.push_back(std::move(node));
      continue;
    }
    std::vector<int> chosen;
    if (node.bound < cut() && choose(node, chosen)) {
      const QpResult whole = solve_program(chosen, &node);
      ++best.nodes;
      best.iterations += whole.iterations;
      if (whole.status == QpStatus::optimal && whole.objective < best.cost) {
        accept(chosen, whole.objective, best);
        best_point = std::make_shared<StagePoint>(point_);
      }
    }
    if (node.bound >= cut()) {
      closed.push_back(std::move(node));
      continue;
    }
    // Children in the order of their shares; the first one is gone on with.
    const int depth = static_cast<int>(node.path.size());
    const SetStage& stage = stages_->of(sets[depth], depth == 0);
    std::vector<double> share = stage.modes.empty() ? std::vector<double>(graph_.size(), 1.0)
                                                    : shares(stage, node.point->stages[depth]);
    std::vector<Node> children;
    for (int i = 0; i < graph_.size(); ++i) {
      if ((sets[depth] & only(i)) == 0 || !graph_.may_append(node.path, i, before_)) continue;
      Node child = node;
      child.path.push_back(i);
      children.push_back(std::move(child));
    }
    std::sort(children.begin(), children.end(), [&](const Node& a, const Node& b) {
      return share[a.path.back()] > share[b.path.back()];
    });
    for (std::size_t i = 0; i < children.size(); ++i) {
      if (i == 0) {
        dive.push_back(std::move(children[i]));
        continue;
      }
      open.push_back(std::move(children[i]));
      std::push_heap(open.begin(), open.end(), worse);
    }
  }

  double bound = std::min(best.cost, lowest_closed);
  for (const std::vector<Node>* list : {&open, &dive})
    for (const Node& node : *list) bound = std::min(bound, node.bound);
  for (const Node& node : closed)
    if (node.bound >= cut()) bound = std::min(bound, node.bound);
  best.lower_bound = bound;
  leaves_ = std::move(closed);
  for (std::vector<Node>* list : {&open, &dive})
    for (Node& node : *list) leaves_.push_back(std::move(node));
  best_ = best.modes;
  best_point_ = best_point;
  best.sequence = graph_.names_of(best.modes);
  const bool closed_gap = best.found() && best.gap() <= options_.gap * (1.0 + options_.gap);
  best.guarantee = closed_gap                                            ? Guarantee::optimal
                   : stopped || best.found() || lowest_closed < infinity ? Guarantee::bounded
                                                                         : Guarantee::infeasible;
  finish(best);
  best.solver_seconds = solver_seconds_;
  best.seconds = seconds_since(begin);
  return best;
}

void SequenceSearch::finish(SequenceResult& result) {
  const int N = options_.phases;
  result.message = describe(result.guarantee);
  if (!result.found()) return;
  for (int k = 0; k <= N; ++k)
    result.states.push_back(stages_->physical(best_point_->stages[k].x.head(stages_->states())));
  result.states.front() = stages_->physical(start_);
  for (int k = 0; k < N; ++k) {
    const StagePoint::AtStage& at = best_point_->stages[k];
    const int nu = stages_->mode(result.modes[k]).stage.nu;
    result.inputs.push_back(stages_->input(result.modes[k], at.x.head(stages_->states()),
                                           at.u.head(nu),
                                           best_point_->stages[k + 1].x.head(stages_->states())));
  }
  if (!options_.confirm) return;
  OptimalControlProblem problem = graph_.problem(result.modes);
  problem.start_at(stages_->physical(start_));
  MultipleShooting shooting(
      std::move(problem),
      {.intervals_per_phase = 1,
       .integrator = options_.integrator ? options_.integrator : zero_order_hold()});
  const auto solver = make_sqp({.tolerance = options_.tolerance});
  result.solution = saltus::solve(shooting, *solver);
}

// --- from tick to tick ---------------------------------------------------------------------------

namespace {

double stage_cost(const Stage& stage, const StagePoint::AtStage& at) {
  StageQp qp;
  qp.stages.push_back(stage);
  StagePoint point;
  point.stages.push_back(at);
  return objective(qp, point);
}

}  // namespace

// framework/design/sequences.md, "The tree of the last tick".
std::shared_ptr<const SequenceSearch::Dual> SequenceSearch::dual_of(int depth) const {
  const int nx = stages_->states(), N = options_.phases;
  if (N < 2) return nullptr;
  auto dual = std::make_shared<Dual>();
  dual->depth = depth;
  dual->cost = objective(qp_, point_) - stage_cost(qp_.stages[0], point_.stages[0]) -
               stage_cost(qp_.stages[N], point_.stages[N]);
  dual->first = point_.stages[0].costate.head(nx);
  dual->first_state = point_.stages[1].x.head(nx);
  dual->last = point_.stages[N - 1].costate.head(nx);
  dual->last_state = point_.stages[N].x.head(nx);
  const Stage& s = qp_.stages[1];
  const StagePoint::AtStage& p = point_.stages[1];
  for (int j = 0; j < nx; ++j)
    if (p.x_bound[j] != 0.0)
      dual->limits.push_back(
          {VectorXd::Unit(nx, j), p.x_bound[j] > 0.0 ? s.x_upper[j] : s.x_lower[j], p.x_bound[j]});
  for (std::size_t g = 0; g < s.groups.size(); ++g) {
    const RowGroup& group = s.groups[g];
    for (int i = 0; i < group.rows; ++i) {
      const double lambda = p.group[g][i];
      VectorXd normal = VectorXd::Zero(nx);
      bool of_state = lambda != 0.0;
      for (std::size_t c = 0; c < group.columns.size(); ++c) {
        const double entry = group.M(i, static_cast<int>(c));
        if (group.columns[c] < nx)
          normal[group.columns[c]] = entry;
        else
          of_state = of_state && entry == 0.0;
      }
      if (of_state)
        dual->limits.push_back({normal, lambda > 0.0 ? group.upper[i] : group.lower[i], lambda});
    }
  }
  return dual;
}

double SequenceSearch::shifted_bound(const Dual& dual, ModeSet last) {
  if (dual.depth < 2 || last == 0) return -infinity;  // its first phase was relaxed
  const SetStage& set = stages_->of(last, false);
  tail_qp_.stages[0] = set.stage;
  tail_qp_.stages[0].q -= dual.last;
  tail_qp_.stages[1].x_lower = stages_->end().x_lower.cwiseMax(set.end_lower);
  tail_qp_.stages[1].x_upper = stages_->end().x_upper.cwiseMin(set.end_upper);
  const QpResult tail = tail_solver_->solve(tail_qp_, tail_point_, false);
  if (tail.status != QpStatus::optimal) return -infinity;
  double bound = dual.cost + dual.last.dot(dual.last_state) +
                 dual.first.dot(start_ - dual.first_state) + tail.objective;
  for (const Limit& limit : dual.limits)
    bound -= std::max(0.0, limit.multiplier * (limit.normal.dot(start_) - limit.side));
  // Multipliers and states are what the solver's tolerance lets them be.
  const double sizes = 1.0 + dual.first.lpNorm<1>() + dual.last.lpNorm<1>() +
                       dual.first_state.lpNorm<1>() + dual.last_state.lpNorm<1>();
  return bound - options_.tolerance * sizes * options_.phases;
}

std::shared_ptr<const StagePoint> SequenceSearch::shifted_point(const StagePoint& from) const {
  const int N = options_.phases;
  auto to = std::make_shared<StagePoint>(from);
  for (int k = 0; k + 1 < N; ++k) to->stages[k] = from.stages[k + 1];
  StagePoint::AtStage& last = to->stages[N - 1];
  last.x.head(stages_->states()) = from.stages[N].x.head(stages_->states());
  last.u.setZero();
  last.x_bound.setZero();
  last.u_bound.setZero();
  for (VectorXd& group : last.group) group.setZero();
  return to;
}

std::vector<SequenceSearch::Node> SequenceSearch::shifted() {
  std::vector<Node> result;
  std::map<const StagePoint*, std::shared_ptr<const StagePoint>> points;
  std::map<std::pair<const Dual*, ModeSet>, double> bounds;
  for (Node& leaf : leaves_) {
    if (leaf.path.empty()) return {};
    if (leaf.path.front() != best_.front()) continue;
    if (leaf.path.size() == 1) return {};
    Node& node = result.emplace_back();
    node.path.assign(leaf.path.begin() + 1, leaf.path.end());
    const ModeSet last = sets_of(node.path).back();
    if (leaf.dual) {
      const auto [it, is_new] = bounds.try_emplace({leaf.dual.get(), last}, 0.0);
      if (is_new) it->second = shifted_bound(*leaf.dual, last);
      node.bound = it->second;
    }
    if (leaf.point && !leaf.point_path.empty()) {
      std::shared_ptr<const StagePoint>& moved = points[leaf.point.get()];
      if (!moved) moved = shifted_point(*leaf.point);
      node.point = moved;
      node.point_path.assign(leaf.point_path.begin() + 1, leaf.point_path.end());
    }
  }
  return result;
}

}  // namespace saltus
