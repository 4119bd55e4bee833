#include "saltus/sequences/search.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>
#include <set>
#include <utility>

#include "saltus/core/clock.hpp"
#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/sequences/mode_stages.hpp"
#include "saltus/sequences/sequence_search.hpp"
#include "saltus/solver/infeasibility_proof.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/verdict.hpp"

namespace saltus {
namespace {

// Part of the split phase that an inserted or appended phase takes in the initial guess.
constexpr double inserted_part = 0.1, appended_part = 0.5;

// Default of SearchOptions::least_cost.
constexpr double least_cost = 1e-6;
// A sequence cheaper than its prefix by this relative amount violates costs_are_nonnegative.
constexpr double broken = 1e-5;

using Path = std::vector<int>;

// Start of a solve: durations of the phases, and states and inputs from the trajectory of a shorter
// sequence at the same times. Without a source, it uses the guesses of the modes.
struct Start {
  const Solution* source = nullptr;
  std::vector<double> durations = {};
};

class Enumeration {
 public:
  Enumeration(const ModeGraph& graph, const SearchOptions& options)
      : graph_(graph),
        options_(options),
        solver_(make_native_solver({.tolerance = options.tolerance})),
        deadline_(seconds_after(begin_, options.deadline)) {
    solver_->set_deadline(deadline_);
  }

  SequenceResult run() {
    const int most = options_.phases > 0 ? options_.phases : options_.at_most;
    // Sort by cost of the prefix, then longer first. Without such costs, shorter first, because
    // longer sequences start from the results of shorter ones.
    const auto later = [&](const Open& a, const Open& b) {
      if (a.bound != b.bound) return a.bound > b.bound;
      if (a.path.size() != b.path.size())
        return prunes() ? a.path.size() < b.path.size() : a.path.size() > b.path.size();
      return a.path > b.path;
    };
    std::set<Open, std::function<bool(const Open&, const Open&)>> open(
        [&](const Open& a, const Open& b) { return later(b, a); });
    open.insert(Open{});
    best_.least_cost = options_.least_cost > 0.0 ? options_.least_cost : least_cost;
    bool stopped = false;
    while (!open.empty()) {
      if (WallClock::now() >= deadline_ || best_.nodes >= options_.max_nodes) {
        stopped = true;
        break;
      }
      Open node = *open.begin();
      open.erase(open.begin());
      if (node.bound >= best_.cost) {
        ++ruled_out_;
        continue;
      }
      const int length = static_cast<int>(node.path.size());
      const bool may_end = length > 0 && graph_.may_end(node.path.back()) &&
                           (options_.phases == 0 || length == options_.phases);
      if (may_end) solve_whole(node.path, node.bound);
      if (most > 0 && length == most) continue;
      if (length > 0 && prunes() && !may_end) {
        const Solution beginning = solve_once(node.path, best_start(node.path), true);
        if (beginning.status == SolveStatus::infeasible) {
          ++ruled_out_;
          all_proved_ = all_proved_ && last_failure_is_proof_;
          continue;
        }
        if (beginning.ok() && beginning.cost >= best_.cost) {
          ++ruled_out_;
          continue;
        }
        if (beginning.ok()) {
          node.bound = beginning.cost;
          solved_.insert_or_assign(node.path, beginning);
        }
      }
      for (int mode = 0; mode < graph_.size(); ++mode) {
        if (!graph_.may_append(node.path, mode, {})) continue;
        Open child = node;
        child.path.push_back(mode);
        if (is_too_long(child.path)) continue;
        open.insert(std::move(child));
      }
    }
    const bool interrupted = stopped || WallClock::now() >= deadline_;
    best_.guarantee = !sign_violation_.empty() ? SequenceResult::Guarantee::contradicted
                      : interrupted            ? SequenceResult::Guarantee::incomplete
                      : best_.found()          ? SequenceResult::Guarantee::enumerated
                      : all_proved_            ? SequenceResult::Guarantee::infeasible
                                               : SequenceResult::Guarantee::inconclusive;
    best_.message = fmt::format(
        "{}; {}{} programs were solved, {} prefixes were excluded, and for {} sequences the solver "
        "found no solution",
        describe(best_.guarantee), sign_violation_, best_.nodes, ruled_out_,
        best_.infeasible + best_.unresolved);
    if (!best_.found() && !first_failure_.empty())
      best_.message += "; the first: " + first_failure_;
    if (best_.found()) verify_best();
    best_.seconds = seconds_since(begin_);
    return std::move(best_);
  }

 private:
  struct Open {
    double bound = -infinity;
    Path path;
  };

  // Prefixes can be compared only for sequences of known duration.
  bool prunes() const {
    if (!options_.costs_are_nonnegative || options_.phases == 0) return false;
    for (int i = 0; i < graph_.size(); ++i)
      if (graph_.mode(i).has_free_duration()) return false;
    return true;
  }

  // The shortest and the longest duration of a path, s.
  Bounds time_of(const Path& path) const {
    Bounds sum = exactly(0.0);
    for (const int mode : path) {
      sum.lower += graph_.mode(mode).duration.lower;
      sum.upper += graph_.mode(mode).duration.upper;
    }
    return sum;
  }

  bool is_too_long(const Path& path) const {
    return graph_.total_time() && time_of(path).lower > graph_.total_time()->upper + same_instant;
  }

  void solve_whole(const Path& path, double prefix_bound) {
    if (graph_.total_time() && time_of(path).upper < graph_.total_time()->lower - same_instant) {
      ++best_.infeasible;  // too short: proved infeasible
      return;
    }
    Solution best;
    best.cost = infinity;
    bool infeasible = false, proved = false;
    for (const Start& start : starts(path)) {
      Solution s = solve_once(path, start, false);
      infeasible = infeasible || s.status == SolveStatus::infeasible;
      proved = proved || (s.status == SolveStatus::infeasible && last_failure_is_proof_);
      if (!s.ok() && first_failure_.empty()) first_failure_ = s.message;
      if (s.ok() && s.cost < best.cost) best = std::move(s);
      if (WallClock::now() >= deadline_) break;
    }
    if (!best.ok()) {
      ++(infeasible ? best_.infeasible : best_.unresolved);
      all_proved_ = all_proved_ && proved;
      return;
    }
    const double size = std::max(std::abs(best.cost), best_.least_cost);
    if (best.cost < prefix_bound - broken * size && sign_violation_.empty())
      sign_violation_ =
          fmt::format("costs_are_nonnegative is set, but '{}' costs {:.9g} and its prefix {:.9g}; ",
                      fmt::join(graph_.names_of(path), ", "), best.cost, prefix_bound);
    if (best.cost < best_.cost - options_.gap * size) {
      best_.cost = best.cost;
      best_.modes = path;
      best_.sequence = graph_.names_of(path);
      best_.solution = best;
    }
    solved_.insert_or_assign(path, std::move(best));
  }

  void verify_best() {
    const MultipleShooting shooting(
        posed(best_.modes, {}, false),
        {.intervals_per_phase = options_.intervals_per_phase,
         .integrator = options_.integrator ? options_.integrator : runge_kutta4({.steps = 2})});
    apply_verification(shooting, best_.solution);
    if (!best_.solution.ok()) best_.message += "; " + best_.solution.message;
  }

  Solution solve_once(const Path& path, const Start& start, bool is_prefix) {
    ++best_.nodes;
    last_failure_is_proof_ = false;
    Solution result;
    try {
      OptimalControlProblem problem = posed(path, start, is_prefix);
      MultipleShooting shooting(
          std::move(problem),
          {.intervals_per_phase = options_.intervals_per_phase,
           .integrator = options_.integrator ? options_.integrator : runge_kutta4({.steps = 2}),
           .accuracy = {.verify = false}});  // only the returned plan is verified
      result = saltus::solve(shooting, *solver_);
      last_failure_is_proof_ = result.status == SolveStatus::infeasible &&
                               is_proved_infeasible(shooting.nlp(), result.point.w);
    } catch (const DefinitionError& e) {  // e.g. times that this sequence cannot satisfy
      result.status = SolveStatus::invalid_problem;
      result.cost = infinity;
      result.message = e.what();
    }
    best_.iterations += result.iterations;
    return result;
  }

  OptimalControlProblem posed(const Path& path, const Start& start, bool is_prefix) const {
    // A single free duration that the total time determines counts as fixed.
    int free_phases = 0;
    double fixed = 0.0;
    for (const int mode : path) {
      const PhaseDefinition& m = graph_.mode(mode);
      free_phases += m.has_free_duration() ? 1 : 0;
      fixed += m.has_free_duration() ? 0.0 : m.duration.lower;
    }
    const bool is_decided =
        free_phases == 1 && !is_prefix && graph_.total_time() && graph_.total_time()->is_equality();
    double begin = 0.0;
    return graph_.problem(
        path,
        [&](int k, PhaseDefinition& phase) {
          if (is_decided && phase.has_free_duration()) {
            const double rest = graph_.total_time()->lower - fixed;
            const Bounds& allowed = phase.duration;
            if (rest < allowed.lower - same_instant || rest > allowed.upper + same_instant)
              throw DefinitionError(fmt::format("phase '{}' would last {} s", phase.name, rest));
            phase.duration = exactly(std::clamp(rest, allowed.lower, allowed.upper));
          }
          if (!start.durations.empty() && phase.has_free_duration())
            phase.duration_guess =
                std::clamp(start.durations[k], phase.duration.lower, phase.duration.upper);
          if (start.durations.empty() || start.source == nullptr) return;
          const double from = graph_.start_time() + begin, lasts = start.durations[k];
          begin += lasts;
          const Solution* source = start.source;
          if (phase.sizes.nx == source->trajectory.final_state().size())
            phase.state_guess = Guess::trajectory(
                [=](double f) { return source->trajectory.state(from + f * lasts); });
          if (phase.sizes.nu > 0 &&
              source->trajectory.input(from + 0.5 * lasts).size() == phase.sizes.nu)
            phase.input_guess = Guess::trajectory(
                [=](double f) { return source->trajectory.input(from + f * lasts); });
        },
        is_prefix);
  }

  Start best_start(const Path& path) const {
    const auto it = solved_.find(Path(path.begin(), path.end() - 1));
    if (it == solved_.end()) return {};
    std::vector<double> durations = it->second.durations;
    durations.push_back(graph_.mode(path.back()).duration.lower);
    return {&it->second, std::move(durations)};
  }

  // Start points of a sequence: the guesses of the modes, the sequence without its last mode, and
  // every sequence that lacks one interrupting mode. With a fixed total time, the last mode takes
  // part of the time of the mode before it.
  std::vector<Start> starts(const Path& path) const {
    std::vector<Start> result;
    const int n = static_cast<int>(path.size());
    if (const auto it = solved_.find(Path(path.begin(), path.end() - 1)); it != solved_.end()) {
      std::vector<double> durations = it->second.durations;
      if (graph_.total_time() && graph_.total_time()->is_equality()) {
        const double taken = appended_part * durations.back();
        durations.back() -= taken;
        durations.push_back(taken);
      } else {
        durations.push_back(graph_.mode(path.back()).has_free_duration()
                                ? graph_.mode(path.back()).duration_guess
                                : graph_.mode(path.back()).duration.lower);
      }
      result.push_back({&it->second, std::move(durations)});
    }
    for (int i = 1; i + 1 < n; ++i) {
      if (path[i - 1] != path[i + 1] || !graph_.mode(path[i]).has_free_duration()) continue;
      Path shorter = path;
      shorter.erase(shorter.begin() + i, shorter.begin() + i + 2);
      const auto it = solved_.find(shorter);
      if (it == solved_.end()) continue;
      std::vector<double> durations = it->second.durations;
      const double whole = durations[i - 1];
      durations[i - 1] = 0.5 * (1.0 - inserted_part) * whole;
      durations.insert(durations.begin() + i, {inserted_part * whole, durations[i - 1]});
      result.push_back({&it->second, std::move(durations)});
    }
    Start& own = result.emplace_back();
    if (graph_.total_time() && graph_.total_time()->is_equality()) {
      // Scale the guesses to the available time.
      double sum = 0.0;
      for (const int mode : path) sum += guess_of(mode);
      for (const int mode : path)
        own.durations.push_back(guess_of(mode) * graph_.total_time()->upper / sum);
    }
    return result;
  }

  double guess_of(int mode) const {
    const PhaseDefinition& m = graph_.mode(mode);
    return m.has_free_duration() ? m.duration_guess : m.duration.lower;
  }

  WallClock::time_point begin_ = WallClock::now();
  const ModeGraph& graph_;
  const SearchOptions& options_;
  std::unique_ptr<Solver> solver_;
  WallClock::time_point deadline_;
  std::map<Path, Solution> solved_;
  SequenceResult best_;
  long ruled_out_ = 0;
  bool last_failure_is_proof_ = false;  // the last program is proved to be infeasible
  bool all_proved_ = true;              // all failed sequences were proved infeasible
  std::string sign_violation_, first_failure_;
};

}  // namespace

SequenceResult search(const ModeGraph& graph, const SearchOptions& options) {
  if (options.phases < 0 || options.at_most < 0 || (options.phases > 0 && options.at_most > 0))
    throw DefinitionError(
        fmt::format("search: phases is {} and at_most is {}; set only one of them", options.phases,
                    options.at_most));
  if (const int most = SearchOptions::most_phases; std::max(options.phases, options.at_most) > most)
    throw DefinitionError(fmt::format("search: phases is {} and at_most is {}, expected at most {}",
                                      options.phases, options.at_most, most));
  graph.check(options.phases > 0 || options.at_most > 0);
  if (options.phases == 0 && options.at_most == 0 && !graph.total_time())
    throw DefinitionError(
        fmt::format("modes '{}': nothing limits the sequence; set phases or at_most in the search, "
                    "or total_time() of the modes",
                    graph.name()));
  std::string reason = "the number of phases is not given";
  if (options.phases > 0) {
    ModeStages stages(graph, options.integrator ? options.integrator : zero_order_hold(),
                      options.phases);
    reason = stages.reason();
    if (reason.empty()) return SequenceSearch(graph, options).solve(graph.start());
  }
  SequenceResult result = Enumeration(graph, options).run();
  result.message += fmt::format(" (not convex in sampled time: {})", reason);
  return result;
}

}  // namespace saltus
