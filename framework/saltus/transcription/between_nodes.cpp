#include "saltus/transcription/between_nodes.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "saltus/ocp/windows_of.hpp"
#include "saltus/transcription/verdict.hpp"

namespace saltus {
namespace {

// Largest violation relative to its tolerance, in the units of its term.
Verification::Miss largest(const VerificationDetail& found) {
  Verification::Miss worst;
  for (const VerificationDetail::Path& f : found.violated)
    if (f.miss.amount > worst.amount) worst = f.miss;
  return worst;
}

// Number of pieces for an interval that exceeds a tolerance by the factor `excess`. Violations fall
// at least with the square of the length, so more pieces would be excessive.
int pieces_for(double excess) {
  if (!(excess > 1.0)) return 1;
  return static_cast<int>(std::clamp(std::ceil(std::sqrt(excess)), 2.0, 4.0));
}

// Largest excess over the tolerances within each input interval of a phase.
std::vector<double> worst_of_inputs(const Mesh& mesh, const Trajectory& trajectory, int phase,
                                    const std::vector<double>& excess) {
  const std::vector<Mesh::InputInterval> inputs = mesh.input_intervals();
  std::vector<double> worst(inputs.size(), 0.0);
  double begin = infinity, end = 0.0;
  for (const Trajectory::Piece& p : trajectory.pieces()) {
    if (p.phase != phase) continue;
    begin = std::min(begin, p.start);
    end = p.end();
  }
  for (std::size_t i = 0; i < excess.size(); ++i) {
    const Trajectory::Piece& p = trajectory.pieces()[i];
    if (p.phase != phase) continue;
    const double middle = (p.start + 0.5 * p.length - begin) / (end - begin);
    std::size_t k = 0;
    while (k + 1 < inputs.size() && mesh.fraction(inputs[k + 1].first) <= middle) ++k;
    worst[k] = std::max(worst[k], excess[i]);
  }
  return worst;
}

// If a window ends inside a phase of free duration, intervals on either side must stay equal, and
// the whole phase is refined.
bool needs_equal_intervals(const PhaseDefinition& phase) {
  if (!phase.has_free_duration()) return false;
  bool cuts = false;
  for_each_window(phase, [&](const Window& window, const auto&) {
    cuts = cuts || is_after_start(window.from) || is_after_start(window.to);
  });
  return cuts;
}

// Excess of each interval over its tolerances, and whether the plan passes an obstacle between two
// nodes, i.e. has a violation too large for a bulge of the path.
struct Judgement {
  std::vector<double> excess = {};  // per piece of the trajectory
  bool passes_obstacle = false;
};

Judgement judge(const MultipleShooting& shooting, const VerificationDetail& found,
                const RefinementOptions& options) {
  constexpr double obstacle = 1e-2;  // relative to the scale of a term; larger than a bulge
  Judgement result;
  for (const VerificationDetail::Path& f : found.violated)
    result.passes_obstacle = result.passes_obstacle || f.miss.amount > obstacle * f.scale;
  const double share = options.integration / static_cast<double>(found.intervals.size());
  const bool is_off = !(found.summary.defect.sum <= options.integration);
  constexpr double halved = 4.0;  // an integration error falls faster than a bulge
  for (const VerificationDetail::Interval& i : found.intervals) {
    double excess = std::max(i.violation / options.tolerance, i.excess);
    const double defect =
        std::max(is_off ? i.defect / share : 0.0, i.defect / shooting.options().accuracy.defect);
    result.excess.push_back(std::max(excess, std::min(defect, halved)));
  }
  return result;
}

// Computes the meshes of the next round. Returns false if the limit is reached everywhere. If the
// plan passed an obstacle, all inputs are held: with more freedom the plan would pass it between
// the new nodes.
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
      if (!mesh.holds.empty()) {  // input intervals stay as they are
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

std::string describe(const VerificationDetail& found, const RefinementOptions& options,
                     const std::vector<int>& intervals) {
  int total = 0;
  for (const int n : intervals) total += n;
  const Verification::Miss miss = largest(found);
  std::string text =
      miss.amount == 0.0
          ? fmt::format("path constraints hold between the nodes of {} intervals", total)
          : fmt::format(
                "path constraints hold between the nodes of {} intervals except for {:.3g} "
                "('{}' of phase '{}' at t = {:.6g} s)",
                total, miss.amount, miss.term, miss.phase, miss.time);
  if (!(found.summary.defect.sum <= options.integration))
    text += fmt::format("; the integration error is {:.1e}", found.summary.defect.sum);
  return text;
}

bool is_grid_optimum(const Solution& solution) {
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
  if (!is_grid_optimum(result.solution)) {
    result.message = fmt::format("the solve on the first grid failed: {}", result.solution.message);
    return result;
  }
  for (int round = 1;; ++round) {
    // The verification must resolve a tenth of the tolerance.
    const VerificationDetail found =
        verify_plan(result.shooting, result.solution, 0.1 * refinement.tolerance);
    result.violations.push_back(largest(found).amount);
    result.message = describe(found, refinement, result.intervals);
    result.reached = result.solution.ok() && result.violations.back() <= refinement.tolerance &&
                     found.summary.defect.sum <= refinement.integration;
    if (result.reached) return result;
    if (round >= refinement.rounds) {
      result.message += fmt::format("; stopped after {} rounds", round);
      return result;
    }
    if (!refine(result.shooting, result.solution.trajectory,
                judge(result.shooting, found, refinement), refinement, options.meshes)) {
      result.message += fmt::format("; stopped with {} intervals per phase, the limit is {}",
                                    fmt::join(result.intervals, ", "), refinement.most_intervals);
      return result;
    }
    MultipleShooting finer(problem, options);
    Solution next = attempt(finer, finer.guess_from(result.solution.trajectory));
    if (!is_grid_optimum(next) && next.status != SolveStatus::interrupted)
      next = attempt(finer, finer.initial_guess());
    if (!is_grid_optimum(next)) {
      result.message += fmt::format("; the solve on the next grid failed: {}", next.message);
      return result;
    }
    result.shooting = std::move(finer);
    result.solution = std::move(next);
    count_intervals();
  }
}

}  // namespace saltus
