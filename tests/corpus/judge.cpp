#include <fmt/format.h>

#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/solver/ipopt.hpp"
#include "tests/corpus/claims.hpp"
#include "tests/corpus/stationarity.hpp"
#include "tests/corpus/trial.hpp"

namespace saltus::corpus {
namespace {

constexpr double promised_gain = 1e-3;  // relative; smaller at a KKT point
constexpr double cost_agreement = 1e-3;
constexpr double steady =
    1e3;  // amplification up to which an open-loop miss counts as an error of the plan

std::vector<PlanPiece> plan_of(const Solution& solution) {
  std::vector<PlanPiece> plan;
  for (const Trajectory::Piece& piece : solution.trajectory.pieces()) {
    const IntervalProblem& interval =
        solution.trajectory.phases()[piece.phase].integrator->problem();
    const int nu = interval.arguments.nu;
    const bool is_linear = interval.shape == InputShape::linear;
    plan.push_back({piece.phase, piece.start, piece.length, piece.state, piece.end_state,
                    piece.coefficients.head(nu),
                    is_linear ? piece.coefficients.tail(nu) : piece.coefficients.head(nu),
                    is_linear});
  }
  return plan;
}

bool is_finite(const std::vector<PlanPiece>& plan) {
  for (const PlanPiece& p : plan)
    if (!p.state.allFinite() || !p.end_state.allFinite() || !p.first_input.allFinite() ||
        !p.last_input.allFinite() || !std::isfinite(p.length))
      return false;
  return !plan.empty();
}

std::string describe(const char* kind, const Miss& miss) {
  return fmt::format("{}: {} by {:.3g}, allowed {:.1g}", kind, miss.what, miss.amount,
                     miss.tolerance);
}

struct Notes {
  bool unreported = false, imprecise = false;
  bool is_coarse = false;  // errors exceed the accuracy that the framework requires of itself
};

// Reason why the plan is wrong, or empty if it is right.
std::string fault_of(const Instance& instance, const Solution& solution, Notes& notes) {
  const std::vector<PlanPiece> plan = plan_of(solution);
  if (!is_finite(plan)) return "the plan contains a number that is not finite";
  const OutsideCheck check = check_outside(instance.phases, plan);
  if (!check.simulated) return "the judge cannot integrate the plan";
  notes.is_coarse = check.stated_defect.is_broken();
  if (check.path.is_broken()) return describe("path", check.path);
  if (check.end.is_broken()) return describe("end", check.end);
  if (check.defect.is_broken()) return describe("integration", check.defect);
  Miss open = check.open_loop_end;
  if (instance.amplification <= steady) {
    notes.imprecise = open.is_broken();
    // The tolerance is that of the end plus the stated accuracy of the integration.
    open.tolerance = std::max(open.tolerance, 1e-3 * std::max(1.0, check.largest_state));
    if (open.is_broken()) return describe("open loop", open);
  } else {
    notes.unreported = open.is_broken();
  }
  if (!(std::abs(check.cost - solution.cost) <=
        cost_agreement * std::max(std::abs(check.cost), std::abs(solution.cost)) + 1e-9)) {
    // The judge does not compute the part of the cost from soft terms.
    if (instance.optimum == std::nullopt)
      return fmt::format("reported cost {:.6g}, cost along the plan {:.6g}", solution.cost,
                         check.cost);
  }
  if (instance.optimum) {
    const double allowed = instance.optimum_tolerance * std::abs(*instance.optimum) + 1e-9;
    if (!(std::abs(solution.cost - *instance.optimum) <= allowed))
      return fmt::format("cost {:.8g} instead of {:.8g}", solution.cost, *instance.optimum);
  }
  // A cost equal to the known optimum cannot decrease further.
  const bool is_known = instance.optimum && std::abs(solution.cost - *instance.optimum) <=
                                                promised_gain * std::abs(*instance.optimum);
  if (instance.is_kkt_judged && !is_known) {
    const Stationarity s = stationarity(instance.phases, plan, instance.cost_scale);
    if (!(s.residual <= promised_gain))
      return fmt::format("no KKT point: the cost can decrease by {:.2g} of its size along the {}",
                         s.residual, s.variable);
  }
  return instance.further ? instance.further(solution) : std::string{};
}

Verdict judge(const Instance& instance, const Solution& solution) {
  Notes notes;
  const std::string fault = fault_of(instance, solution, notes);
  if (solution.ok()) {
    if (!instance.is_solvable)
      return {Outcome::wrong, "ok() although there is no solution; " + fault};
    if (!fault.empty()) return {Outcome::wrong, fault};
    if (notes.unreported && !(stated_growth(solution) >= 0.01 * instance.amplification)) {
      return {Outcome::unreported,
              fmt::format("the ends are missed in open loop, amplification {:.1g}",
                          instance.amplification)};
    }
    return {Outcome::right, {}, notes.imprecise};
  }
  if (!instance.is_solvable || instance.may_be_either) return {Outcome::reported, solution.message};
  if (solution.message.starts_with("the constraints cannot all be satisfied"))
    return {Outcome::wrong, "false proof: " + solution.message};
  const bool is_right = fault.empty() && !notes.unreported;
  // The grid is too coarse, and the status reports it.
  if (solution.status == SolveStatus::coarse_grid && (!is_right || notes.is_coarse))
    return {Outcome::reported, solution.message};
  if (is_right) return {Outcome::refused, solution.message};
  return {Outcome::unsolved, fmt::format("{} [{}]", solution.message, fault)};
}

}  // namespace

Verdict run_trial(const CorpusClass& family, std::uint64_t seed,
                  std::optional<SolverChoice> choice) {
  try {
    // The solver has a separate random draw, so that the problem of a seed does not depend on it.
    constexpr SolverChoice all[] = {SolverChoice::sparse, SolverChoice::riccati,
                                    SolverChoice::ipopt};
    const SolverChoice chosen = choice.value_or(all[seed % 3]);
    Random random(seed);
    Instance instance = family.make(random);
    if (instance.run) return instance.run(chosen);
    instance.options.solver = make_solver(chosen, {.time_limit = 20.0});
    Solution solution;
    try {
      solution = solve(instance.problem, instance.options);
    } catch (const DefinitionError& error) {
      if (!instance.is_solvable) return {Outcome::reported, error.what()};
      throw;
    }
    return judge(instance, solution);
  } catch (const std::exception& error) {
    return {Outcome::unsolved, fmt::format("exception: {}", error.what())};
  }
}

}  // namespace saltus::corpus
