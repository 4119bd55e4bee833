#include "saltus/transcription/between_nodes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/ocp/windows_of.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {
namespace {

// What a path constraint reads and where it goes beyond its bounds.
struct Reading {
  double amount = 0.0;  // of the violation
  int output = 0;
};

// A path constraint of one phase: bounds on the outputs of a formula, or on one state.
struct PathConstraint {
  const Term* term = nullptr;
  const ComponentBounds* state = nullptr;
  PhaseWindow window;
  VectorXd given;  // of every output, where nobody chose the start; empty: of no such interval
  PathViolation worst;
  int worst_output = 0;
  VectorXd at;                  // the argument where it is worst
  VectorXd least, most, value;  // of every output along the phase

  int outputs() const { return state != nullptr ? 1 : term->function.outputs(); }

  const VectorXd& evaluate(const VectorXd& z, const Arguments& a) {
    if (state != nullptr)
      value[0] = z[a.x(state->component)];
    else
      term->function.value(z.data(), value.data());
    return value;
  }

  // The way back from a given start is within bounds that reach as far as it.
  Reading read(const VectorXd& z, const Arguments& a) {
    evaluate(z, a);
    Reading result;
    for (int i = 0; i < value.size(); ++i) {
      Bounds b = state != nullptr ? state->bounds : term->bounds[i];
      if (given.size() > 0) b = {std::min(b.lower, given[i]), std::max(b.upper, given[i])};
      least[i] = std::min(least[i], value[i]);
      most[i] = std::max(most[i], value[i]);
      const double beyond = std::isfinite(value[i])
                                ? std::max({b.lower - value[i], value[i] - b.upper, 0.0})
                                : infinity;
      if (beyond > result.amount) result = {beyond, i};
    }
    return result;
  }

  // See PathViolation::scale.
  double scale(const PhaseDefinition& phase) const {
    const Arguments& a = phase.sizes;
    if (state != nullptr)
      return std::max(most[0] - least[0], phase.nominal_state[state->component]);
    const MatrixXd slope = term->function.dense_jacobian(at);
    double by_nominal = 0.0;
    for (int i = 0; i < a.nx; ++i)
      by_nominal += std::abs(slope(worst_output, a.x(i))) * phase.nominal_state[i];
    for (int i = 0; i < a.nu; ++i)
      by_nominal += std::abs(slope(worst_output, a.u(i))) * phase.nominal_input[i];
    const double range = most[worst_output] - least[worst_output];
    const double scale = std::max(range, std::isfinite(by_nominal) ? by_nominal : 0.0);
    return scale > 0.0 ? scale : 1.0;
  }
};

std::vector<PathConstraint> path_constraints(const Grid& grid, const PhaseDefinition& phase,
                                             int j) {
  std::vector<PathConstraint> list;
  const auto add = [&](const Term* term, const ComponentBounds* state, const Window& window,
                       std::string name) {
    PathConstraint& c = list.emplace_back();
    c.term = term;
    c.state = state;
    c.window = grid.resolve(j, window);
    c.worst = {phase.name, std::move(name)};
    c.value = VectorXd::Zero(c.outputs());
    c.least = VectorXd::Constant(c.outputs(), infinity);
    c.most = -c.least;
  };
  for (const Term& term : phase.terms)
    if (term.kind == TermKind::constraint && term.domain == TermDomain::running && !term.soft)
      add(&term, nullptr, term.window, term.name);
  for (const ComponentBounds& b : phase.state_bounds)
    add(nullptr, &b, b.window, fmt::format("bounds of state {}", b.component));
  return list;
}

struct BetweenNodes {
  std::vector<PathViolation> terms;  // the largest first
  std::vector<double> intervals;     // of each piece of the trajectory, its largest violation
};

BetweenNodes look_between_nodes(const MultipleShooting& shooting, const Trajectory& trajectory,
                                int samples) {
  BetweenNodes result;
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
      double& largest = result.intervals.emplace_back(0.0);
      if (!(here.length > 0.0)) continue;  // of a phase that has vanished
      in_force.clear();
      for (PathConstraint& c : constraints)
        if (grid.interval_in(j, k, c.window)) in_force.push_back(&c);
      const bool begins_as_given =
          &here == &trajectory.pieces().front() && shooting.data().has_given_start();
      for (PathConstraint* c : in_force) {
        c->given.resize(0);
        if (!begins_as_given) continue;
        z << here.start, here.state, trajectory.input(here.start),
            trajectory.phases()[j].parameters;
        c->given = c->evaluate(z, phase.sizes);
      }
      for (int s = 1; s <= samples && !in_force.empty(); ++s) {
        const double t = here.start + here.length * s / (samples + 1);
        if (&trajectory.piece_at(t) != &here) continue;  // shorter than time can be told
        z << t, trajectory.state(t), trajectory.input(t), trajectory.phases()[j].parameters;
        for (PathConstraint* c : in_force) {
          const Reading reading = c->read(z, phase.sizes);
          largest = std::max(largest, reading.amount);
          if (reading.amount <= c->worst.amount) continue;
          c->worst.amount = reading.amount;
          c->worst.time = t;
          c->worst_output = reading.output;
          c->at = z;
        }
      }
    }
    for (PathConstraint& c : constraints)
      if (c.worst.amount > 0.0) {
        c.worst.scale = c.scale(phase);
        result.terms.push_back(std::move(c.worst));
      }
  }
  std::stable_sort(
      result.terms.begin(), result.terms.end(),
      [](const PathViolation& a, const PathViolation& b) { return a.amount > b.amount; });
  return result;
}

}  // namespace

std::vector<PathViolation> violations_between_nodes(const MultipleShooting& shooting,
                                                    const Trajectory& trajectory, int samples) {
  return look_between_nodes(shooting, trajectory, samples).terms;
}

namespace {

double largest(const std::vector<PathViolation>& violations) {
  return violations.empty() ? 0.0 : violations.front().amount;
}

// Into how many pieces an interval is cut that misses a tolerance so many times. A bulge falls at
// least with the square of the length, so that more than that would be too much.
int pieces_for(double excess) {
  if (!(excess > 1.0)) return 1;
  return static_cast<int>(std::clamp(std::ceil(std::sqrt(excess)), 2.0, 4.0));
}

// How many times the worst interval within each input interval of a phase misses what is asked of
// it.
std::vector<double> worst_of_inputs(const Mesh& mesh, const Trajectory& trajectory, int phase,
                                    const std::vector<double>& excess) {
  const std::vector<Mesh::InputInterval> inputs = mesh.input_intervals();
  std::vector<double> worst(inputs.size(), 0.0);
  double begin = infinity, end = 0.0;
  for (const TrajectoryPiece& p : trajectory.pieces()) {
    if (p.phase != phase) continue;
    begin = std::min(begin, p.start);
    end = p.end();
  }
  for (std::size_t i = 0; i < excess.size(); ++i) {
    const TrajectoryPiece& p = trajectory.pieces()[i];
    if (p.phase != phase) continue;
    const double middle = (p.start + 0.5 * p.length - begin) / (end - begin);
    std::size_t k = 0;
    while (k + 1 < inputs.size() && mesh.fraction(inputs[k + 1].first) <= middle) ++k;
    worst[k] = std::max(worst[k], excess[i]);
  }
  return worst;
}

// Where a window ends inside a phase of free duration, intervals stay equal on both sides of it,
// and the phase is refined as a whole.
bool needs_equal_intervals(const PhaseDefinition& phase) {
  if (!phase.has_free_duration()) return false;
  bool cuts = false;
  for_each_window(phase, [&](const Window& window, const auto&) {
    cuts = cuts || is_after_start(window.from) || is_after_start(window.to);
  });
  return cuts;
}

// How many times each interval misses what is asked of it, and whether the plan passes an obstacle
// between two nodes: a violation that a bulge does not explain.
struct Judgement {
  std::vector<double> excess;  // of each piece of the trajectory
  bool passes_obstacle = false;
};

Judgement judge(const MultipleShooting& shooting, const BetweenNodes& between,
                const std::optional<IntegrationError>& integration,
                const RefinementOptions& options) {
  Judgement result{between.intervals};
  double tolerance = options.tolerance;  // below it, too, a plan may be none
  for (const PathViolation& v : between.terms) {
    const double allowed = shooting.options().accuracy.between_nodes;
    if (v.relative() <= allowed) continue;
    result.passes_obstacle = true;
    tolerance = std::min(tolerance, allowed * v.scale);
  }
  for (double& e : result.excess) e /= tolerance;
  if (!integration || integration->states <= options.integration) return result;
  const double share = options.integration / static_cast<double>(result.excess.size());
  constexpr double halved = 4.0;  // its error falls faster than a bulge: two pieces will do
  for (std::size_t i = 0; i < result.excess.size(); ++i)
    result.excess[i] =
        std::max(result.excess[i], std::min(integration->intervals[i] / share, halved));
  return result;
}

// The meshes of the next round; false: the limit is reached everywhere. If an obstacle was passed
// all inputs are held: with more freedom the plan would pass the next finer interval.
bool refine(const MultipleShooting& shooting, const Trajectory& trajectory, const Judgement& judged,
            const RefinementOptions& options, std::vector<Mesh>& meshes) {
  bool changed = false;
  for (int j = 0; j < static_cast<int>(meshes.size()); ++j) {
    Mesh& mesh = meshes[j];
    const std::vector<double> excess = worst_of_inputs(mesh, trajectory, j, judged.excess);
    const int most = pieces_for(*std::max_element(excess.begin(), excess.end()));
    if (most == 1) continue;
    if (needs_equal_intervals(shooting.problem().phases()[j])) {
      const int factor = std::min(most, options.most_intervals / mesh.intervals);
      if (factor < 2) continue;
      if (!mesh.holds.empty()) {  // what one input acts on stays so
        std::vector<char> holds(static_cast<std::size_t>(mesh.intervals * factor) + 1, 1);
        for (int i = 0; i <= mesh.intervals; ++i)
          holds[static_cast<std::size_t>(i * factor)] = mesh.holds_input(i) ? 1 : 0;
        mesh.holds = std::move(holds);
      }
      mesh.intervals *= factor;
      changed = true;
      continue;
    }
    std::vector<Mesh::Cut> cuts;
    const std::vector<Mesh::InputInterval> inputs = mesh.input_intervals();
    for (std::size_t i = 0; i < inputs.size(); ++i)
      cuts.push_back({inputs[i].count * pieces_for(excess[i]),
                      options.hold_inputs || judged.passes_obstacle || inputs[i].count > 1});
    Mesh finer = mesh.divided(cuts);
    if (finer.intervals > options.most_intervals) continue;
    mesh = std::move(finer);
    changed = true;
  }
  return changed;
}

std::string describe(const PathViolation& v, const std::optional<IntegrationError>& integration,
                     const RefinementOptions& options, const std::vector<int>& intervals) {
  int total = 0;
  for (const int n : intervals) total += n;
  std::string text =
      v.amount == 0.0
          ? fmt::format("path constraints hold between the nodes of {} intervals", total)
          : fmt::format(
                "path constraints hold between the nodes of {} intervals but for {:.3g} "
                "('{}' of phase '{}' at t = {:.6g} s)",
                total, v.amount, v.term, v.phase, v.time);
  if (integration && integration->states > options.integration)
    text += fmt::format("; the integration is off by {:.1e}", integration->states);
  return text;
}

bool is_solved_on_its_grid(const Solution& solution) {
  return solution.ok() || solution.status == SolveStatus::coarse_grid;
}

}  // namespace

RefinedSolution solve_refined(const OptimalControlProblem& problem, ShootingOptions options,
                              Solver& solver, const RefinementOptions& refinement) {
  MultipleShooting first(problem, options);
  options = first.options();
  RefinedSolution result{.shooting = std::move(first), .solution = {}};
  const auto attempt = [&](MultipleShooting& shooting, const NlpPoint& start) {
    Solution solution = solve(shooting, solver, start);
    result.iterations += solution.iterations;
    result.seconds += solution.seconds;
    return solution;
  };
  result.solution = attempt(result.shooting, result.shooting.initial_guess());
  const auto count_intervals = [&] {
    result.intervals.clear();
    for (const Mesh& mesh : options.meshes) result.intervals.push_back(mesh.intervals);
  };
  count_intervals();
  if (!is_solved_on_its_grid(result.solution)) {
    result.message = fmt::format("the first grid is not solved: {}", result.solution.message);
    return result;
  }
  for (int round = 1;; ++round) {
    const BetweenNodes between =
        look_between_nodes(result.shooting, result.solution.trajectory, samples_between_nodes);
    const std::optional<IntegrationError>& integration = result.solution.integration;
    result.violations.push_back(largest(between.terms));
    result.message = describe(between.terms.empty() ? PathViolation{} : between.terms.front(),
                              integration, refinement, result.intervals);
    result.reached = result.solution.ok() && result.violations.back() <= refinement.tolerance &&
                     (!integration || integration->states <= refinement.integration);
    if (result.reached) return result;
    if (round >= refinement.rounds) {
      result.message += fmt::format("; ended after {} rounds", round);
      return result;
    }
    if (!refine(result.shooting, result.solution.trajectory,
                judge(result.shooting, between, integration, refinement), refinement,
                options.meshes)) {
      result.message += fmt::format("; ended with {} per phase, of at most {} intervals",
                                    fmt::join(result.intervals, ", "), refinement.most_intervals);
      return result;
    }
    MultipleShooting finer(problem, options);
    Solution next = attempt(finer, finer.guess_from(result.solution.trajectory));
    if (!is_solved_on_its_grid(next) && next.status != SolveStatus::interrupted)
      next = attempt(finer, finer.initial_guess());
    if (!is_solved_on_its_grid(next)) {
      result.message += fmt::format("; the next grid is not solved: {}", next.message);
      return result;
    }
    result.shooting = std::move(finer);
    result.solution = std::move(next);
    count_intervals();
  }
}

}  // namespace saltus
