#include "saltus/transcription/between_nodes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/transcription/shooting_program.hpp"

namespace saltus {
namespace {

// A path constraint of one phase: bounds on the outputs of a formula, or on one state.
struct PathConstraint {
  const Term* term = nullptr;
  const ComponentBounds* state = nullptr;
  PhaseWindow window;
  PathViolation worst;

  double miss(const VectorXd& z, const Arguments& a) const {
    const auto outside = [](double value, const Bounds& b) {
      return std::isfinite(value) ? std::max({b.lower - value, value - b.upper, 0.0}) : infinity;
    };
    if (state != nullptr) return outside(z[a.x(state->component)], state->bounds);
    const VectorXd value = term->function(z);
    double largest = 0.0;
    for (int i = 0; i < value.size(); ++i)
      largest = std::max(largest, outside(value[i], term->bounds[i]));
    return largest;
  }
};

std::vector<PathConstraint> path_constraints(const Grid& grid, const PhaseDefinition& phase,
                                             int j) {
  std::vector<PathConstraint> list;
  for (const Term& term : phase.terms)
    if (term.kind == TermKind::constraint && term.domain == TermDomain::running && !term.soft)
      list.push_back({&term, nullptr, grid.resolve(j, term.window), {phase.name, term.name}});
  for (const ComponentBounds& b : phase.state_bounds)
    list.push_back({nullptr,
                    &b,
                    grid.resolve(j, b.window),
                    {phase.name, fmt::format("bounds of state {}", b.component)}});
  return list;
}

}  // namespace

std::vector<PathViolation> violations_between_nodes(const MultipleShooting& shooting,
                                                    const Trajectory& trajectory, int samples) {
  std::vector<PathViolation> result;
  const Grid& grid = shooting.grid();
  auto piece = trajectory.pieces().begin();
  for (int j = 0; j < grid.phases() && !trajectory.empty(); ++j) {
    const PhaseDefinition& phase = shooting.problem().phases()[j];
    std::vector<PathConstraint> constraints = path_constraints(grid, phase, j);
    std::vector<PathConstraint*> in_force;
    VectorXd z(phase.sizes.size());
    for (int k = 0; k < grid.intervals(j); ++k) {
      if (grid.interval(j, k).is_empty()) continue;
      const TrajectoryPiece& here = *piece++;
      in_force.clear();
      for (PathConstraint& c : constraints)
        if (grid.interval_in(j, k, c.window)) in_force.push_back(&c);
      for (int s = 1; s <= samples && !in_force.empty(); ++s) {
        const double t = here.start + here.length * s / (samples + 1);
        z << t, trajectory.state(t), trajectory.input(t), trajectory.phases()[j].parameters;
        for (PathConstraint* c : in_force) {
          const double amount = c->miss(z, phase.sizes);
          if (amount <= c->worst.amount) continue;
          c->worst.amount = amount;
          c->worst.time = t;
        }
      }
    }
    for (PathConstraint& c : constraints)
      if (c.worst.amount > 0.0) result.push_back(std::move(c.worst));
  }
  std::stable_sort(
      result.begin(), result.end(),
      [](const PathViolation& a, const PathViolation& b) { return a.amount > b.amount; });
  return result;
}

namespace {

double largest(const std::vector<PathViolation>& violations) {
  return violations.empty() ? 0.0 : violations.front().amount;
}

// Twice to four times the intervals where the tolerance is missed. A bulge falls at least with the
// square of the interval, so that more would be too much. False: the limit is reached everywhere.
bool refine(const OptimalControlProblem& problem, const std::vector<PathViolation>& violations,
            const RefinementOptions& options, std::vector<int>& intervals) {
  bool changed = false;
  for (std::size_t j = 0; j < intervals.size(); ++j) {
    double amount = 0.0;
    for (const PathViolation& v : violations)
      if (v.phase == problem.phases()[j].name) amount = std::max(amount, v.amount);
    if (!(amount > options.tolerance)) continue;
    const double wanted = std::clamp(std::ceil(std::sqrt(amount / options.tolerance)), 2.0, 4.0);
    const int possible = options.most_intervals / std::max(1, intervals[j]);
    const int factor = std::min(static_cast<int>(wanted), possible);
    if (factor < 2) continue;
    intervals[j] *= factor;
    changed = true;
  }
  return changed;
}

std::string describe(const PathViolation& v, const std::vector<int>& intervals) {
  int total = 0;
  for (const int n : intervals) total += n;
  if (v.amount == 0.0)
    return fmt::format("path constraints hold between the nodes of {} intervals", total);
  return fmt::format(
      "path constraints hold between the nodes of {} intervals but for {:.3g} ('{}' of phase '{}' "
      "at t = {:.6g} s)",
      total, v.amount, v.term, v.phase, v.time);
}

}  // namespace

RefinedSolution solve_refined(const OptimalControlProblem& problem, ShootingOptions options,
                              const SolverFactory& make_solver,
                              const RefinementOptions& refinement) {
  if (options.intervals.empty())
    options.intervals.assign(problem.phases().size(), options.intervals_per_phase);
  const auto attempt = [&](MultipleShooting& shooting, const NlpPoint& start) {
    return solve(shooting, *make_solver(shooting), start);
  };
  MultipleShooting first(problem, options);
  Solution solution = attempt(first, first.initial_guess());
  RefinedSolution result{std::move(first), std::move(solution), options.intervals, {}, false, {}};
  if (!result.solution.ok()) {
    result.message = fmt::format("the first grid is not solved: {}", result.solution.message);
    return result;
  }
  for (int round = 1;; ++round) {
    const std::vector<PathViolation> violations =
        violations_between_nodes(result.shooting, result.solution.trajectory);
    result.violations.push_back(largest(violations));
    result.message =
        describe(violations.empty() ? PathViolation{} : violations.front(), result.intervals);
    result.reached = result.violations.back() <= refinement.tolerance;
    if (result.reached) return result;
    if (round >= refinement.rounds) {
      result.message += fmt::format("; ended after {} rounds", round);
      return result;
    }
    if (!refine(problem, violations, refinement, options.intervals)) {
      result.message += fmt::format("; ended at {} intervals per phase", refinement.most_intervals);
      return result;
    }
    MultipleShooting finer(problem, options);
    Solution next = attempt(finer, finer.guess_from(result.solution.trajectory));
    if (!next.ok()) next = attempt(finer, finer.initial_guess());
    if (!next.ok()) {
      result.message += fmt::format("; the next grid is not solved: {}", next.message);
      return result;
    }
    result.shooting = std::move(finer);
    result.solution = std::move(next);
    result.intervals = options.intervals;
  }
}

}  // namespace saltus
