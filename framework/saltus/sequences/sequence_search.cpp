#include "saltus/sequences/sequence_search.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <map>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/sequences/dual_bound.hpp"
#include "saltus/sequences/mode_stages.hpp"
#include "saltus/solver/native_solver.hpp"

namespace saltus {
namespace {

// If all shares of a relaxed solution are this close to 0 or 1, its sequence is tried immediately.
constexpr double nearly_integral = 1e-3;
// Rounding level of a proof, relative to the terms that it adds.
constexpr double rounding = 1e-9;
// Contradictory bounds of one state that differ by less, relative to their size, differ by
// rounding.
constexpr double same_bound = 1e-9;
// The cost of the relaxed problem divides the costs, so that tolerances are relative to it. The
// divisor is at least this fraction of the largest cost coefficient, which is also the floor of the
// gap. It is recomputed if costs change by more than the second factor.
constexpr double least_part = 1e-6, rescale_factor = 10.0;
// The floor is at least this fraction of the relaxed problem's cost. Rounding errors of sums of
// such numbers do not count as a gap.
constexpr double rounding_part = 1e-4;
constexpr int unit_rounds = 3;
// Accepted difference between solver and search, relative to the cost and to its largest
// coefficient.
constexpr double same_cost = 1e-5, same_zero = 1e-8;
// If the dual bound of a program is off by more than this fraction of the gap, the program is
// solved again with this fraction of the tolerance.
constexpr double loose_bound = 0.25, finer = 1e-3;
// Number of sequences that are solved before the search reports infeasibility.
constexpr std::size_t tried_sequences = 4;
// With more leaves than this, moving them to the next tick costs more than a new search.
constexpr std::size_t max_leaves = 5000;

// Initial barrier parameter of a node, in units of the cost. Its start, the optimum of its parent,
// is farther away than that of the previous tick. (1e-5, 1e-3, 1e-2 and 3e-2 were tried.)
constexpr double warm_barrier = 1e-2;

std::unique_ptr<qp::StageQpSolver> solver_for(const qp::StageQp& capacity, double tolerance) {
  qp::RiccatiOptions options;
  options.tolerance = tolerance;
  options.warm_barrier = warm_barrier;
  return qp::make_riccati_solver(capacity, options);
}

ModeGraph checked(ModeGraph graph, const SearchOptions& options) {
  if (options.phases < 1 || options.phases > SearchOptions::most_phases)
    throw DefinitionError(fmt::format(
        "modes '{}': the horizon has {} phases, expected 1 to {}; set SearchOptions::phases",
        graph.name(), options.phases, SearchOptions::most_phases));
  if (!(options.gap >= 0.0) || !(options.least_cost >= 0.0) || !(options.tolerance > 0.0) ||
      !(options.deadline > 0.0))
    throw DefinitionError(
        "search: gap and least_cost must not be negative, tolerance and deadline positive");
  graph.check(true);
  return graph;
}

}  // namespace

SequenceSearch::SequenceSearch(ModeGraph graph, SearchOptions options)
    : graph_(checked(std::move(graph), options)),
      options_(std::move(options)),
      stages_(std::make_unique<ModeStages>(
          graph_, options_.integrator ? options_.integrator : zero_order_hold(), options_.phases)),
      time_(graph_.start_time()) {
  if (!stages_->reason().empty())
    throw DefinitionError(fmt::format("modes '{}': the problem is not convex in sampled time: {}",
                                      graph_.name(), stages_->reason()));
  const double phase = graph_.mode(0).duration.lower, total = options_.phases * phase;
  if (const std::optional<Bounds>& asked = graph_.total_time();
      asked && (total < asked->lower - same_instant || total > asked->upper + same_instant))
    throw DefinitionError(
        fmt::format("modes '{}': {} phases of {} s last {:.6g} s, but the total time is [{}, {}] s",
                    graph_.name(), options_.phases, phase, total, asked->lower, asked->upper));
  qp_ = stages_->capacity(options_.phases, true);
  solver_ = solver_for(qp_, options_.tolerance);
  point_ = qp::StagePoint(qp_);
  tail_qp_ = stages_->capacity(1, false);
  tail_solver_ = solver_for(tail_qp_, options_.tolerance);
  tail_point_ = qp::StagePoint(tail_qp_);
  const double largest = stages_->largest_cost();
  least_unit_ = options_.least_cost > 0.0 ? options_.least_cost : least_part * largest;
  least_cost_ = least_unit_;
  unit_ = std::max(largest, least_unit_);
  stages_->divide_costs(unit_);
  holds_.assign(options_.phases + 1, nullptr);  // the end has no inputs
  fill_ends();
  for (int i = 0; i < graph_.size(); ++i) {
    ModeSet& next = successors_.emplace_back(0);
    for (int j = 0; j < graph_.size(); ++j)
      if (graph_.may_follow(i, j)) next |= only(j);
    if (graph_.may_end(i)) ends_ |= only(i);
  }
}

SequenceSearch::SequenceSearch(SequenceSearch&&) noexcept = default;
SequenceSearch& SequenceSearch::operator=(SequenceSearch&&) noexcept = default;
SequenceSearch::~SequenceSearch() = default;

// Copies the end of stages_ into the programs.
void SequenceSearch::fill_ends() {
  qp_.stages.back() = tail_qp_.stages.back() = stages_->end();
  filled_.assign(options_.phases, 0);
  tail_set_ = 0;
}

// The end depends on the start time if it reads the time.
void SequenceSearch::begin_at(double time) {
  if (!std::isfinite(time))
    throw DefinitionError(fmt::format("modes '{}': the time is not finite", graph_.name()));
  const bool moves = time != time_ && graph_.end_reads_time();
  if (moves)
    stages_->end_after(graph_, time + (options_.phases - 1) * graph_.mode(0).duration.lower);
  time_ = time;
  if (moves) fill_ends();
}

double SequenceSearch::relative_gap() const {
  return std::max(options_.gap, 2.0 * options_.tolerance);
}

// Scale of the relative gap, in units of the programs.
double SequenceSearch::size_of(double cost) const {
  return std::max(std::abs(cost), least_cost_ / unit_);
}

// Possible modes of every phase: those reachable from the path and from which an end is reachable.
// Ignores dwell times and limits on entries, which is a relaxation.
std::vector<ModeSet> SequenceSearch::sets_of(const std::vector<int>& path) const {
  const int N = options_.phases, fixed = static_cast<int>(path.size());
  std::vector<ModeSet> sets(N, 0);
  for (int k = 0; k < N; ++k) {
    if (k > 0) {
      for (ModeSet from = sets[k - 1]; from != 0; from &= from - 1)
        sets[k] |= successors_[std::countr_zero(from)];
      if (k < fixed) sets[k] &= only(path[k]);
    } else if (fixed > 0) {
      sets[k] = only(path[k]);
    } else {
      for (int i = 0; i < graph_.size(); ++i)
        if (graph_.may_append({}, i, before_) && stages_->admits(i, start_)) sets[k] |= only(i);
    }
    sets[k] &= ~stages_->impossible();
    if (k == N - 1) sets[k] &= stages_->is_end_feasible() ? ends_ : 0;
  }
  for (int k = N - 2; k >= 0; --k)
    for (ModeSet from = sets[k]; from != 0; from &= from - 1)
      if ((successors_[std::countr_zero(from)] & sets[k + 1]) == 0)
        sets[k] &= ~only(std::countr_zero(from));
  return sets;
}

// Bounds of the state at the border between phases k - 1 and k.
void SequenceSearch::limits_of(const std::vector<ModeSet>& sets, int k, VectorXd& lower,
                               VectorXd& upper) {
  const SetStage& before = stages_->of(sets[k - 1], k == 1);
  const qp::Stage& here = k < options_.phases ? stages_->of(sets[k], false).stage : stages_->end();
  lower = here.x_lower.cwiseMax(before.end_lower);
  upper = here.x_upper.cwiseMin(before.end_upper);
  for (int j = 0; j < lower.size(); ++j)
    if (lower[j] > upper[j] && lower[j] - upper[j] <= same_bound * (1.0 + std::abs(upper[j])))
      lower[j] = upper[j] = 0.5 * (lower[j] + upper[j]);
}

qp::QpResult SequenceSearch::solve_program(const std::vector<int>& path, const Node* from) {
  const std::vector<ModeSet> sets = sets_of(path);
  qp::QpResult result;
  result.status = qp::QpStatus::infeasible;
  for (const ModeSet set : sets)
    if (set == 0) return result;
  if (!path.empty() && !stages_->admits(path.front(), start_)) return result;
  const int N = options_.phases;
  bool previous_changed = false;
  for (int k = 0; k <= N; ++k) {
    const bool changed = k < N && filled_[k] != sets[k];
    if (changed) {
      SetStage& set = stages_->of(sets[k], k == 0);
      qp_.stages[k] = set.stage;
      holds_[k] = &set.hold;
      filled_[k] = sets[k];
    }
    if (k > 0 && (changed || previous_changed))
      limits_of(sets, k, qp_.stages[k].x_lower, qp_.stages[k].x_upper);
    previous_changed = changed;
  }
  for (int k = 1; k <= N; ++k)  // contradictory bounds of consecutive modes
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
  const auto solve_from = [&](bool is_warm) {
    const int before_that = result.iterations;
    const double begin = thread_microseconds();
    result = solver_->solve(qp_, point_, is_warm);
    solver_seconds_ += 1e-6 * (thread_microseconds() - begin);
    // If the solver made no iterations, the two sides of a row contradict each other.
    if (result.status == qp::QpStatus::infeasible && result.iterations > 0 &&
        !proves_infeasible(qp_, point_, holds_))
      result.status = qp::QpStatus::numerical_failure;
    result.iterations += before_that;
  };
  result.iterations = 0;
  solve_from(warm);
  if (warm && result.status != qp::QpStatus::optimal && result.status != qp::QpStatus::infeasible &&
      result.status != qp::QpStatus::deadline)
    solve_from(false);
  if (result.status != qp::QpStatus::optimal) return result;
  const auto bound_of = [&](const qp::QpResult& r, const qp::StagePoint& point) {
    return dual_bound(qp_, point, holds_,
                      r.objective - options_.tolerance * std::max(1.0, std::abs(r.objective)));
  };
  dual_bound_ = bound_of(result, point_);
  if (dual_bound_ >= result.objective - loose_bound * relative_gap() * size_of(result.objective))
    return result;
  if (!fine_solver_) fine_solver_ = solver_for(qp_, finer * options_.tolerance);
  fine_solver_->set_deadline(deadline_);
  qp::StagePoint fine_point = point_;
  const double begin = thread_microseconds();
  qp::QpResult fine = fine_solver_->solve(qp_, fine_point, true);
  solver_seconds_ += 1e-6 * (thread_microseconds() - begin);
  fine.iterations += result.iterations;
  result.iterations = fine.iterations;
  if (fine.status != qp::QpStatus::optimal) return result;
  const double bound = bound_of(fine, fine_point);
  if (bound <= dual_bound_) return result;
  dual_bound_ = bound;
  point_ = std::move(fine_point);
  return fine;
}

// After the root of a new tree: rescales the costs by its cost.
void SequenceSearch::settle_unit(qp::QpResult& root) {
  for (int round = 0; round < unit_rounds && root.status == qp::QpStatus::optimal; ++round) {
    const double wanted = std::max(std::abs(root.objective) * unit_, least_unit_);
    least_cost_ = options_.least_cost > 0.0 ? options_.least_cost
                                            : std::max(least_unit_, rounding_part * wanted);
    if (wanted <= rescale_factor * unit_ && rescale_factor * wanted >= unit_) return;
    const double last = std::exchange(unit_, wanted);
    stages_->divide_costs(unit_);
    fill_ends();
    const int iterations = root.iterations;
    qp::QpResult again = solve_program({}, nullptr);
    if (again.status != qp::QpStatus::optimal) {  // tolerance too tight for the solver
      unit_ = last;
      stages_->divide_costs(unit_);
      fill_ends();
      again = solve_program({}, nullptr);
      round = unit_rounds;
    }
    root = again;
    root.iterations += iterations;
  }
}

// mu of every mode of a set, by index of the mode.
std::vector<double> SequenceSearch::shares(const SetStage& stage,
                                           const qp::StagePoint::AtStage& point) const {
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

// True if the relaxed solution determines a sequence: every share is nearly 0 or 1.
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

void SequenceSearch::check(const VectorRef& state) const {
  if (state.size() != stages_->states())
    throw DefinitionError(fmt::format("modes '{}': the state has {} entries, expected {}",
                                      graph_.name(), state.size(), stages_->states()));
  if (!state.allFinite())
    throw DefinitionError(fmt::format("modes '{}': the state is not finite", graph_.name()));
}

SequenceResult SequenceSearch::solve(const VectorRef& state, ModeGraph::History before) {
  return solve(state, before, graph_.start_time());
}

SequenceResult SequenceSearch::solve(const VectorRef& state, ModeGraph::History before,
                                     double time) {
  check(state);
  const auto begin = WallClock::now();
  begin_at(time);
  start_ = stages_->scaled(state);
  before_ = before;
  leaves_.clear();
  best_.clear();
  return run(std::vector<Node>(1), begin);
}

SequenceResult SequenceSearch::solve_next(const VectorRef& state) {
  check(state);
  const double time = time_ + graph_.mode(0).duration.lower;
  if (best_.empty()) return solve(state, before_, time);
  const int applied = best_.front();
  const ModeGraph::History before{applied, before_.mode == applied ? before_.phases + 1 : 1};
  if (graph_.limits_end() || graph_.limits_entries()) return solve(state, before, time);
  const auto begin = WallClock::now();
  std::vector<Node> leaves = reusable_leaves();
  begin_at(time);
  start_ = stages_->scaled(state);
  before_ = before;
  std::vector<Node> open = shifted(std::move(leaves));
  const long reused = static_cast<long>(open.size());
  if (open.empty() || open.size() > max_leaves) open.assign(1, Node{});
  SequenceResult result = run(std::move(open), begin);
  result.reused = reused;
  return result;
}

SequenceResult SequenceSearch::run(std::vector<Node> open, WallClock::time_point begin) {
  SequenceResult best;
  solver_seconds_ = 0.0;
  const double cpu_begin = thread_microseconds();
  const auto deadline = seconds_after(begin, options_.deadline);
  deadline_ = deadline;
  solver_->set_deadline(deadline);
  std::vector<Node> closed;
  std::shared_ptr<const qp::StagePoint> best_point;
  const int N = options_.phases;
  bool stopped = false;
  double lowest_closed = infinity;  // lowest bound of nodes closed without being excluded
  bool gave_up = false;
  const auto worse = [](const Node& a, const Node& b) { return a.bound > b.bound; };
  std::make_heap(open.begin(), open.end(), worse);
  const auto cut = [&] {
    return best.cost < infinity ? best.cost - relative_gap() * size_of(best.cost) : infinity;
  };
  // The rest of the last tick's sequence comes first, because it is feasible or nearly feasible.
  std::vector<int> wanted =
      best_.empty() ? best_ : std::vector<int>(best_.begin() + 1, best_.end());
  std::vector<Node> dive;  // at most one: the next child to process
  if (!wanted.empty())
    for (std::size_t i = 0; i < open.size(); ++i)
      if (!open[i].path.empty() && open[i].path.size() <= wanted.size() &&
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
    qp::QpResult solved = solve_program(node.path, &node);
    if (node.path.empty() && !node.point) settle_unit(solved);
    ++best.nodes;
    best.iterations += solved.iterations;
    if (solved.status == qp::QpStatus::deadline) {
      stopped = true;
      open.push_back(std::move(node));
      break;
    }
    if (solved.status == qp::QpStatus::infeasible) {
      ++best.infeasible;
      if (solved.iterations > 0) node.proof = std::make_shared<qp::StagePoint>(point_);
      closed.push_back(std::move(node));
      continue;
    }
    const bool complete = static_cast<int>(node.path.size()) == N;
    if (solved.status != qp::QpStatus::optimal) {
      ++best.unresolved;
      if (complete) {
        gave_up = true;
        lowest_closed = std::min(lowest_closed, node.bound);
        closed.push_back(std::move(node));
        continue;
      }
      for (int i = 0; i < graph_.size(); ++i) {  // its bound remains that of its parent
        if (!graph_.may_append(node.path, i, before_)) continue;
        Node child = node;
        child.path.push_back(i);
        open.push_back(std::move(child));
        std::push_heap(open.begin(), open.end(), worse);
      }
      continue;
    }
    node.bound = std::max(node.bound, dual_bound_);
    const std::vector<ModeSet> sets = sets_of(node.path);
    node.point = std::make_shared<qp::StagePoint>(point_);
    node.point_path = node.path;
    node.point_is_shifted = false;
    node.dual = nullptr;
    if (complete) {
      accept(node.path, solved.objective, best);
      if (best.modes == node.path) best_point = node.point;
      lowest_closed = std::min(lowest_closed, node.bound);
      closed.push_back(std::move(node));
      continue;
    }
    std::vector<int> chosen;
    if (node.bound < cut() && choose(node, chosen)) {
      const qp::QpResult whole = solve_program(chosen, &node);
      ++best.nodes;
      best.iterations += whole.iterations;
      if (whole.status == qp::QpStatus::optimal && whole.objective < best.cost) {
        accept(chosen, whole.objective, best);
        best_point = std::make_shared<qp::StagePoint>(point_);
      }
    }
    if (node.bound >= cut()) {
      closed.push_back(std::move(node));
      continue;
    }
    // Children in order of decreasing shares. The search continues with the first one.
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
  best.lower_bound = bound * unit_;
  best.cost *= unit_;
  best.least_cost = least_cost_;
  leaves_ = std::move(closed);
  for (std::vector<Node>* list : {&open, &dive})
    for (Node& node : *list) leaves_.push_back(std::move(node));
  best_ = best.modes;
  best_point_ = best_point;
  best.sequence = graph_.names_of(best.modes);
  const bool closed_gap = best.found() && best.gap() <= relative_gap() * (1.0 + relative_gap());
  best.guarantee = closed_gap                ? SequenceResult::Guarantee::optimal
                   : stopped || best.found() ? SequenceResult::Guarantee::bounded
                   : gave_up                 ? SequenceResult::Guarantee::inconclusive
                                             : SequenceResult::Guarantee::infeasible;
  finish(best);
  best.cpu_seconds = 1e-6 * (thread_microseconds() - cpu_begin);
  best.solver_seconds = solver_seconds_;
  best.seconds = seconds_since(begin);
  return best;
}

void SequenceSearch::finish(SequenceResult& result) {
  const int N = options_.phases;
  result.message = describe(result.guarantee);
  if (!result.found()) {
    if (options_.confirm && result.guarantee == SequenceResult::Guarantee::infeasible)
      confirm_infeasible(result);
    return;
  }
  for (int k = 0; k <= N; ++k)
    result.states.push_back(stages_->physical(best_point_->stages[k].x.head(stages_->states())));
  result.states.front() = stages_->physical(start_);
  for (int k = 0; k < N; ++k) {
    const qp::StagePoint::AtStage& at = best_point_->stages[k];
    const int nu = stages_->mode(result.modes[k]).stage.nu;
    result.inputs.push_back(stages_->input(result.modes[k], at.x.head(stages_->states()),
                                           at.u.head(nu),
                                           best_point_->stages[k + 1].x.head(stages_->states())));
  }
  if (options_.confirm) confirm_plan(result);
}

// --- confirmation --------------------------------------------------------------------------------

Solution SequenceSearch::solve_sequence(const std::vector<int>& path) const {
  OptimalControlProblem problem = graph_.problem(path);
  problem.start_at(stages_->physical(start_)).start_time(time_);
  MultipleShooting shooting(
      std::move(problem),
      {.intervals_per_phase = 1,
       .integrator = options_.integrator ? options_.integrator : zero_order_hold()});
  const auto solver = make_native_solver({.tolerance = options_.tolerance});
  return saltus::solve(shooting, *solver);
}

// Solves the found sequence as a separate problem. Its cost must match that of the search.
void SequenceSearch::confirm_plan(SequenceResult& result) {
  result.solution = solve_sequence(result.modes);
  const Solution& s = result.solution;
  const double least = std::min(result.cost, result.lower_bound);
  const double allowed = same_cost * std::max(std::abs(result.cost), std::abs(s.cost)) +
                         same_zero * stages_->largest_cost();
  // The search covers the sampled program only. Violations between samples are reported separately.
  const bool is_optimum = s.ok() || s.status == SolveStatus::coarse_grid;
  if (is_optimum && s.cost >= least - allowed && s.cost <= result.cost + allowed) {
    if (!s.ok()) result.message += "; its plan: " + s.message;
    return;
  }
  if (is_optimum || s.status == SolveStatus::infeasible) {
    result.guarantee = SequenceResult::Guarantee::contradicted;
    result.message = fmt::format(
        "{}: it found a cost of {:.9g} and bounds all sequences by {:.9g}, but the sequence that "
        "it found {}; please report this problem",
        describe(result.guarantee), result.cost, result.lower_bound,
        is_optimum ? fmt::format("costs {:.9g} when solved separately", s.cost)
                   : fmt::format("is infeasible when solved separately ({})", s.message));
    leaves_.clear();
    best_.clear();
  } else {
    result.guarantee = SequenceResult::Guarantee::inconclusive;
    result.message = fmt::format(
        "inconclusive: the search found a cost of {:.9g} and bounds all sequences by {:.9g}, but "
        "the sequence could not be confirmed: {}",
        result.cost, result.lower_bound, s.message);
  }
  result.lower_bound = -infinity;
}

// Allowed sequences, with different first modes if possible.
std::vector<std::vector<int>> SequenceSearch::sample_sequences(std::size_t most) const {
  constexpr int most_steps = 10000;
  std::vector<std::vector<int>> found;
  int steps = 0;
  std::vector<int> path;
  const auto extend = [&](auto&& self) -> bool {
    if (static_cast<int>(path.size()) == options_.phases) {
      if (!graph_.may_end(path.back())) return false;
      found.push_back(path);
      return true;
    }
    for (int mode = 0; mode < graph_.size() && ++steps < most_steps && found.size() < most;
         ++mode) {
      if (!graph_.may_append(path, mode, before_)) continue;
      path.push_back(mode);
      const bool done = self(self);
      path.pop_back();
      if (done && !path.empty()) return true;
    }
    return false;
  };
  extend(extend);
  return found;
}

// No solve may find a sequence that the search excluded.
void SequenceSearch::confirm_infeasible(SequenceResult& result) {
  for (const std::vector<int>& path : sample_sequences(tried_sequences)) {
    Solution s = solve_sequence(path);
    if (!s.ok() && s.status != SolveStatus::coarse_grid) continue;
    result.guarantee = SequenceResult::Guarantee::contradicted;
    result.message = fmt::format(
        "{}: it excluded every sequence (bound infinity), but {} costs {:.9g} when solved "
        "separately; please report this problem",
        describe(result.guarantee), fmt::join(graph_.names_of(path), ", "), s.cost);
    result.lower_bound = -infinity;
    result.solution = std::move(s);
    leaves_.clear();
    return;
  }
}

// --- from tick to tick ---------------------------------------------------------------------------

namespace {

// Excludes penalties of soft rows, which are not part of the stage's function.
double stage_cost(const qp::Stage& s, const qp::StagePoint::AtStage& p) {
  const auto x = p.x.head(s.nx), u = p.u.head(s.nu);
  double cost = s.constant + s.q.dot(x) + s.r.dot(u) + 0.5 * x.dot(s.Q * x) + u.dot(s.S * x) +
                0.5 * u.dot(s.R * u);
  for (std::size_t g = 0; g < s.groups.size(); ++g) {
    const qp::RowGroup& group = s.groups[g];
    if (!group.soft) continue;
    for (int i = 0; i < group.rows; ++i) {
      double value = 0.0;
      for (std::size_t c = 0; c < group.columns.size(); ++c) {
        const int j = group.columns[c];
        value += group.M(i, static_cast<int>(c)) * (j < s.nx ? p.x[j] : p.u[j - s.nx]);
      }
      const double t = std::max({value - group.upper[i], group.lower[i] - value, 0.0});
      cost += t * (group.l1[i] + 0.5 * group.l2[i] * t);
    }
  }
  return cost;
}

}  // namespace

// Active limits of the state alone, with multipliers. They do not apply to a fixed start.
std::vector<SequenceSearch::Limit> SequenceSearch::limits_at(const qp::Stage& s,
                                                             const qp::StagePoint::AtStage& p,
                                                             const VectorXd& lower,
                                                             const VectorXd& upper) {
  std::vector<Limit> limits;
  for (int j = 0; j < s.nx; ++j)
    if (p.x_bound[j] != 0.0)
      limits.push_back(
          {VectorXd::Unit(s.nx, j), p.x_bound[j] > 0.0 ? upper[j] : lower[j], p.x_bound[j]});
  for (std::size_t g = 0; g < s.groups.size(); ++g) {
    const qp::RowGroup& group = s.groups[g];
    if (group.columns.empty() || group.columns.front() >= s.nx) continue;
    for (int i = 0; i < group.rows; ++i) {
      const double multiplier = p.group[g][i];
      VectorXd normal = VectorXd::Zero(s.nx);
      bool of_state = multiplier != 0.0;
      for (std::size_t c = 0; c < group.columns.size(); ++c) {
        const double entry = group.M(i, static_cast<int>(c));
        if (group.columns[c] < s.nx)
          normal[group.columns[c]] = entry;
        else
          of_state = of_state && entry == 0.0;
      }
      if (of_state)
        limits.push_back({normal, multiplier > 0.0 ? group.upper[i] : group.lower[i], multiplier});
    }
  }
  return limits;
}

// See framework/design/sequences.md, "The tree of the last tick".
std::shared_ptr<const SequenceSearch::Dual> SequenceSearch::dual_of(const qp::StagePoint& point,
                                                                    const std::vector<int>& path) {
  const int nx = stages_->states(), N = options_.phases;
  const std::vector<ModeSet> sets = sets_of(path);
  auto dual = std::make_shared<Dual>();
  dual->depth = static_cast<int>(path.size());
  dual->values.assign(N, 0.0);
  dual->limits.resize(N);
  VectorXd lower, upper;
  for (int k = 0; k < N; ++k) {
    dual->costates.emplace_back(point.stages[k].costate.head(nx));
    if (k == 0) continue;
    const qp::Stage& s = stages_->of(sets[k], false).stage;
    dual->values[k] = stage_cost(s, point.stages[k]) +
                      dual->costates[k].dot(point.stages[k + 1].x.head(nx)) -
                      dual->costates[k - 1].dot(point.stages[k].x.head(nx));
    limits_of(sets, k, lower, upper);
    dual->limits[k] = limits_at(s, point.stages[k], lower, upper);
  }
  return dual;
}

double SequenceSearch::shifted_bound(const Dual& dual, ModeSet last, Dual& next) {
  const int nx = stages_->states(), N = options_.phases;
  if (dual.depth < 2 || last == 0) return -infinity;  // its first phase was relaxed
  const SetStage& set = stages_->of(last, false);
  qp::Stage &stage = tail_qp_.stages[0], &end = tail_qp_.stages[1];
  if (tail_set_ != last) {
    stage = set.stage;
    tail_set_ = last;
  }
  stage.q = set.stage.q - dual.costates[N - 1];
  end.x_lower = stages_->end().x_lower.cwiseMax(set.end_lower);
  end.x_upper = stages_->end().x_upper.cwiseMin(set.end_upper);
  const qp::QpResult tail = tail_solver_->solve(tail_qp_, tail_point_, false);
  if (tail.status != qp::QpStatus::optimal) return -infinity;
  double bound = dual.costates[0].dot(start_) + tail.objective;
  double sizes = 1.0 + dual.costates[0].lpNorm<1>() * start_.lpNorm<1>();
  for (int k = 1; k < N; ++k) {
    bound += dual.values[k];
    sizes += std::abs(dual.values[k]) + dual.costates[k].lpNorm<1>();
  }
  for (const Limit& limit : dual.limits[1])
    bound -= std::max(0.0, limit.multiplier * (limit.normal.dot(start_) - limit.side));

  next.depth = dual.depth - 1;
  next.costates.assign(dual.costates.begin() + 1, dual.costates.end());
  next.costates.emplace_back(tail_point_.stages[0].costate.head(nx));
  next.values.assign(dual.values.begin() + 1, dual.values.end());
  next.values.push_back(stage_cost(stage, tail_point_.stages[0]) +
                        next.costates.back().dot(tail_point_.stages[1].x.head(nx)));
  next.limits.assign(dual.limits.begin() + 1, dual.limits.end());
  next.limits.push_back(
      limits_at(set.stage, tail_point_.stages[0], set.stage.x_lower, set.stage.x_upper));
  // The solver's tolerance limits the accuracy of costates and states.
  return bound - options_.tolerance * sizes;
}

std::shared_ptr<const qp::StagePoint> SequenceSearch::shifted_point(
    const qp::StagePoint& from) const {
  const int N = options_.phases;
  auto to = std::make_shared<qp::StagePoint>(from);
  for (int k = 0; k + 1 < N; ++k) to->stages[k] = from.stages[k + 1];
  qp::StagePoint::AtStage& last = to->stages[N - 1];
  last.x.head(stages_->states()) = from.stages[N].x.head(stages_->states());
  last.u.setZero();
  last.x_bound.setZero();
  last.u_bound.setZero();
  for (VectorXd& group : last.group) group.setZero();
  return to;
}

// Shifts a proof: statements about the end become statements about the end of the last phase but
// one, which has bounds.
std::shared_ptr<const qp::StagePoint> SequenceSearch::shifted_proof(
    const qp::StagePoint& from) const {
  auto proof = std::make_shared<qp::StagePoint>(*shifted_point(from));
  const int N = options_.phases, nx = stages_->states();
  qp::StagePoint::AtStage &last = proof->stages[N - 1], &end = proof->stages[N];
  last.x_bound.head(nx) = from.stages[N - 1].costate.head(nx);
  last.costate.setZero();
  end.x_bound.setZero();
  for (VectorXd& group : end.group) group.setZero();
  return proof;
}

// Farkas: with these multipliers, the sum of all rows and dynamics is positive for every state and
// input within bounds. The remaining gradients are bounded over the boxes.
bool SequenceSearch::is_proved(const std::vector<int>& path, const qp::StagePoint& proof) {
  const std::vector<ModeSet> sets = sets_of(path);
  const int N = options_.phases, nx = stages_->states();
  double value = 0.0, size = 0.0;
  VectorXd lower, upper, rest_x, rest_u;
  const auto add = [&](double multiplier, double below, double above) {
    const double side = multiplier > 0.0 ? above : below;
    if (multiplier == 0.0 || std::isinf(side)) return 0.0;
    value -= multiplier * side;
    size += std::abs(multiplier * side);
    return multiplier;
  };
  for (int k = 0; k <= N; ++k) {
    if (k < N && sets[k] == 0) return true;
    const SetStage* set = k < N ? &stages_->of(sets[k], k == 0) : nullptr;
    const qp::Stage& s = k < N ? set->stage : stages_->end();
    const qp::StagePoint::AtStage& p = proof.stages[k];
    rest_x = VectorXd::Zero(nx);
    rest_u = VectorXd::Zero(s.nu);
    if (k > 0) {
      limits_of(sets, k, lower, upper);
      for (int j = 0; j < nx; ++j) rest_x[j] += add(p.x_bound[j], lower[j], upper[j]);
      rest_x -= proof.stages[k - 1].costate.head(nx);
    }
    for (int j = 0; j < s.nu; ++j) rest_u[j] += add(p.u_bound[j], s.u_lower[j], s.u_upper[j]);
    for (std::size_t g = 0; g < s.groups.size(); ++g) {
      const qp::RowGroup& group = s.groups[g];
      if (group.soft) continue;
      for (int i = 0; i < group.rows; ++i) {
        const double multiplier = add(p.group[g][i], group.lower[i], group.upper[i]);
        if (multiplier == 0.0) continue;
        for (std::size_t c = 0; c < group.columns.size(); ++c) {
          const int j = group.columns[c];
          (j < nx ? rest_x[j] : rest_u[j - nx]) += multiplier * group.M(i, static_cast<int>(c));
        }
      }
    }
    if (k < N) {
      const auto y = p.costate.head(nx);
      rest_x += s.A.transpose() * y;
      rest_u += s.B.transpose() * y;
      value += y.dot(s.b);
      size += (y.array() * s.b.array()).abs().sum();
    }
    if (k == 0) {
      value += rest_x.dot(start_);
      size += (rest_x.array() * start_.array()).abs().sum();
    } else {
      for (int j = 0; j < nx; ++j)
        if (rest_x[j] != 0.0)
          value -= std::abs(rest_x[j]) * std::max(std::abs(lower[j]), std::abs(upper[j]));
    }
    for (int j = 0; j < s.nu; ++j)
      if (rest_u[j] != 0.0) value -= std::abs(rest_u[j]) * set->hold.radius[j];
  }
  return value > rounding * size;
}

// The leaves that begin with the applied mode, with their duals. Call it before start_ changes.
std::vector<SequenceSearch::Node> SequenceSearch::reusable_leaves() {
  std::vector<Node> result;
  std::map<const qp::StagePoint*, std::shared_ptr<const Dual>> duals;
  for (Node& leaf : leaves_) {
    if (!leaf.path.empty() && leaf.path.front() != best_.front()) continue;
    if (leaf.path.size() < 2) return {};  // any sequence may follow: no bound is known
    if (!leaf.dual && !leaf.proof && leaf.point && !leaf.point_is_shifted &&
        !leaf.point_path.empty()) {
      std::shared_ptr<const Dual>& dual = duals[leaf.point.get()];
      if (!dual) dual = dual_of(*leaf.point, leaf.point_path);
      leaf.dual = dual;
    }
    result.push_back(std::move(leaf));
  }
  return result;
}

std::vector<SequenceSearch::Node> SequenceSearch::shifted(std::vector<Node> leaves) {
  std::map<const qp::StagePoint*, std::shared_ptr<const qp::StagePoint>> points;
  struct Moved {
    double bound = -infinity;
    std::shared_ptr<const Dual> dual;
  };
  std::map<std::pair<const Dual*, ModeSet>, Moved> moved;
  for (Node& node : leaves) {
    node.path.erase(node.path.begin());
    node.bound = -infinity;
    const std::shared_ptr<const Dual> dual = std::exchange(node.dual, nullptr);
    if (node.point && !node.point_path.empty()) {
      std::shared_ptr<const qp::StagePoint>& to = points[node.point.get()];
      if (!to) to = shifted_point(*node.point);
      node.point = to;
      node.point_is_shifted = true;
      node.point_path.erase(node.point_path.begin());
    }
    if (node.proof) {
      node.proof = shifted_proof(*node.proof);
      if (is_proved(node.path, *node.proof)) {
        node.bound = infinity;
        continue;
      }
      node.proof = nullptr;
    }
    if (!dual) continue;
    const ModeSet last = sets_of(node.path).back();
    const auto [it, is_new] = moved.try_emplace({dual.get(), last});
    if (is_new) {
      auto next = std::make_shared<Dual>();
      it->second.bound = shifted_bound(*dual, last, *next);
      if (it->second.bound > -infinity) it->second.dual = std::move(next);
    }
    node.bound = it->second.bound;
    node.dual = it->second.dual;
  }
  return leaves;
}

}  // namespace saltus
