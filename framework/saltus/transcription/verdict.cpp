#include "saltus/transcription/verdict.hpp"

#include <fmt/format.h>

#include <string>

#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/replay.hpp"

namespace saltus {
namespace {

constexpr double amplifying = 10.0;  // growth of state errors of an unstable system

std::string describe(const Verification::Miss& miss) {
  std::string text = fmt::format("'{}'", miss.term);
  if (!miss.phase.empty()) text += fmt::format(" of phase '{}'", miss.phase);
  return text + fmt::format(" is violated by {:.3g} at t = {:.6g} s (tolerance {:.2g})",
                            miss.amount, miss.time, miss.tolerance);
}

}  // namespace

VerificationDetail verify_plan(const MultipleShooting& shooting, const Solution& solution,
                               double resolution) {
  const OptimalControlProblem problem = current_problem(shooting);
  Plan plan = plan_of(problem, solution.trajectory);
  plan.cost = solution.cost;
  for (const Solution::CostContribution& c : solution.costs)
    if (c.term == change_of_inputs) plan.grid_cost += c.value;
  return verify(problem, plan, {.accuracy = shooting.options().accuracy, .resolution = resolution});
}

void apply_verification(const MultipleShooting& shooting, Solution& solution) {
  const GridAccuracy& accuracy = shooting.options().accuracy;
  if (!accuracy.verify) return;
  const Verification& v = solution.verification.emplace(verify_plan(shooting, solution).summary);
  if (!solution.ok()) return;
  const auto fail = [&](SolveStatus status, const std::string& what) {
    if (!solution.ok())
      solution.message += "; " + what;
    else if (solution.status == SolveStatus::acceptable)
      solution.message = fmt::format("{}; {}; {}", describe(status), what, solution.message);
    else
      solution.message = fmt::format("{}; {}", describe(status), what);
    if (solution.ok()) solution.status = status;
  };
  const std::string& scheme = shooting.options().integrator->name();
  if (v.at_nodes.is_beyond())
    fail(SolveStatus::numerical_failure,
         "in the units of the problem " + describe(v.at_nodes) +
             ": use a smaller solver tolerance, or declare nominal magnitudes");
  if (v.between_nodes.is_beyond())
    fail(SolveStatus::coarse_grid,
         "between two nodes " + describe(v.between_nodes) +
             ": use more intervals there or solve_refined(), or relax it with allow()");
  if (!(v.defect.largest <= accuracy.defect))
    fail(SolveStatus::coarse_grid,
         fmt::format(
             "within one interval, state {} of phase '{}' at t = {:.6g} s has an error of {:.1e} "
             "of its magnitude ({}): use more intervals or steps, or a smaller tolerance",
             v.defect.state, v.defect.phase, v.defect.time, v.defect.largest, scheme));
  else if (!(v.defect.sum <= accuracy.integration))
    solution.message += fmt::format(
        "; {} has a total error of {:.1e} of the states' magnitudes, most in state {} of phase "
        "'{}' at t = {:.6g} s: use more intervals or steps, or a smaller tolerance",
        scheme, v.defect.sum, v.defect.state, v.defect.phase, v.defect.time);
  if (v.cost.compared && !(v.cost.difference <= accuracy.cost))
    fail(SolveStatus::coarse_grid,
         fmt::format("its cost is {:.6g} instead of {:.6g}: use more intervals or steps",
                     v.cost.value, solution.cost));
  const Verification::OpenLoop& loop = v.open_loop;
  const bool amplifies = !(loop.growth < amplifying);
  const bool misses_end = loop.end.amount > accuracy.open_loop_end * loop.end.tolerance;
  if (loop.completed && (!(loop.states <= accuracy.open_loop) || (amplifies && misses_end))) {
    const std::string what =
        loop.end.amount > 0.0
            ? fmt::format("miss '{}' of phase '{}' by {:.3g} (tolerance {:.2g})", loop.end.term,
                          loop.end.phase, loop.end.amount, loop.end.tolerance)
            : fmt::format(
                  "deviate from the plan by {:.1e} of the magnitude of state {} at the end of "
                  "phase '{}'",
                  loop.states, loop.state, loop.phase);
    // An unstable system amplifies small errors, which only a controller can correct. Without
    // amplification the miss is due to the scheme.
    if (!(v.defect.sum <= accuracy.integration) && !amplifies)
      fail(SolveStatus::coarse_grid,
           fmt::format("the inputs, integrated from the start, {}: use more intervals or steps, or "
                       "a smaller tolerance",
                       what));
    else
      solution.message += fmt::format(
          "; the inputs, integrated from the start, {}: state errors grow by a factor of {:.1e} "
          "along the plan",
          what, loop.growth);
  }
  for (const std::string& sentence : v.not_verified) solution.message += "; " + sentence;
}

}  // namespace saltus
