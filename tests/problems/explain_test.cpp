// Problems of the library and of push recovery, made infeasible in different ways. The explanation
// must name the right term, time and amount, and its remedy must work.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <functional>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "problems/library/catalogue.hpp"
#include "problems/library/reference_case.hpp"
#include "problems/push_recovery/step_program.hpp"
#include "saltus/solve/explain.hpp"
#include "saltus/solve/negotiable_constraints.hpp"
#include "saltus/solver/elastic_program.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"

namespace saltus {
namespace {

const ReferenceCase& library_case(const std::string& id) {
  return *std::ranges::find(reference_cases(), id, &ReferenceCase::id);
}

Term& term(OptimalControlProblem& problem, int phase, const std::string& name) {
  return *std::ranges::find(problem.editable_phase(phase).terms, name, &Term::name);
}

void start_with(OptimalControlProblem& problem, int i, double value) {
  VectorXd start = problem.start_guess();
  start[i] = value;
  problem.start_at(start);
}

// Large forces can compensate any push, unless the body must keep its height and must not
// rotate.
void keep_upright(OptimalControlProblem& problem) {
  problem.editable_phase(0).state_bounds = {
      {2, between(0.49, 0.51)}, {6, between(-0.2, 0.2)}, {7, between(-0.2, 0.2)}};
}

struct Spoilt {
  const char* name;  ///< name of the test: the change to the problem
  const char* id;    ///< identifier of the problem
  std::function<void(OptimalControlProblem&)> spoil;
  const char* term;              ///< term with the largest violation
  double time;                   ///< s; NaN: the end
  std::optional<double> amount;  ///< violation, if known analytically
};

const double at_the_end = std::nan("");

const Spoilt all[] = {
    {"weak_input", "B22",
     [](auto& p) {
       p.editable_phase(0).input_bounds = {{0, between(-0.08, 0.08)}};
     },
     "point", 0.75, 0.04},
    {"weak_inputs", "B21",
     [](auto& p) {
       for (const int j : {0, 1})
         p.editable_phase(j).input_bounds = {{0, between(-0.1, 0.1)}, {1, between(-0.1, 0.1)}};
     },
     "end", at_the_end, std::nullopt},
    {"too_little_time", "B05", [](auto& p) { p.total_time(at_most(20.0)); }, "total time",
     at_the_end, 10.0},
    {"too_far", "B05", [](auto& p) { term(p, 1, "distance").bounds = {exactly(30000.0)}; },
     "distance", at_the_end, std::nullopt},
    {"too_fast_at_the_start", "B18", [](auto& p) { start_with(p, 1, -2.0); }, "at rest", at_the_end,
     std::nullopt},
    {"chain_too_short", "B14a", [](auto& p) { term(p, 0, "length").bounds = {exactly(2.0)}; },
     "length", at_the_end, std::nullopt},
    {"phase_too_short", "B03",
     [](auto& p) {
       p.editable_phase(0).duration = between(0.1, 1.2);
       p.editable_phase(0).duration_guess = 1.0;
     },
     "end, along", at_the_end, std::nullopt},
    {"state_too_high_in_one_phase", "B10",
     [](auto& p) {
       p.editable_phase(2).state_bounds = {{0, at_least(0.999)}};
     },
     "state 0", 0.02, std::nullopt},  // the earlier phases last at least 0.01
    {"weak_inputs_under_a_link", "E02",
     [](auto& p) {
       for (const int j : {1, 2}) p.editable_phase(j).input_bounds = {{0, between(-0.1, 0.1)}};
     },
     "one ahead", at_the_end, std::nullopt},
    {"duration_bound", "B11",
     [](auto& p) {
       p.editable_phase(0).duration = between(0.1, 0.2);
       p.editable_phase(0).duration_guess = 0.15;
     },
     "end", at_the_end, std::nullopt},
    {"too_high", "B15", [](auto& p) { term(p, 0, "height").bounds = {exactly(5.0)}; }, "height",
     at_the_end, std::nullopt},
    {"integral_too_small", "E01",
     [](auto& p) {
       for (int j : {0, 1}) p.editable_phase(j).integrals.front().limits.bounds = {at_most(0.9)};
     },
     "length", at_the_end, std::nullopt},
    {"links_that_contradict", "E02",
     [](auto& p) {
       p.editable_phase(2).duration = between(0.1, 0.2);
       p.editable_phase(2).duration_guess = 0.15;
       p.editable_phase(0).duration = between(0.5, 2.0);
     },
     "equally long", at_the_end, std::nullopt},
    {"event_before_it_can_happen", "A14",
     [](auto& p) {
       p.editable_phase(0).duration = between(0.1, 0.5);
       p.editable_phase(0).duration_guess = 0.3;
     },
     "turbo on", 0.5, 7.5},
    {"too_little_fuel", "B07", [](auto& p) { term(p, 2, "empty").bounds = {exactly(0.999)}; },
     "empty", at_the_end, std::nullopt},
    {"bound_on_a_state", "B22",
     [](auto& p) {
       p.editable_phase(1).state_bounds = {{0, at_most(0.5)}};
     },
     "state 0", 0.75, std::nullopt},
    {"ceiling_below_the_landing", "B02a",
     [](auto& p) {
       term(p, 0, "ground").bounds = {exactly(0.4)};
       p.editable_phase(0).input_bounds = {{0, between(-4.0, 4.0)}};
     },
     "ceiling", 0.75, std::nullopt},  // with -4 at most, the landing speed takes 0.25 s
    {"pushed_too_hard", "C09a",
     [](auto& p) {
       keep_upright(p);
       start_with(p, 4, -1.0);
     },
     "capture point in hull", 0.06, std::nullopt},  // the landing
    {"pushed_forwards", "C09a",
     [](auto& p) {
       keep_upright(p);
       start_with(p, 3, 1.2);
     },
     "capture point in hull", at_the_end, std::nullopt},
    {"landing_too_late", "C09a",
     [](auto& p) {
       keep_upright(p);
       start_with(p, 4, -0.5);
       p.editable_schedule().retime("impact", 0.14);
     },
     "capture point in hull", at_the_end, std::nullopt},
};

// ---- the step planner of push recovery ----------------------------------------------------------

using push_recovery::reach_rows;
using push_recovery::StepModel;

// A step that cannot recover: one foot or both in contact, and a moving capture point.
struct LostStep {
  const char* name;
  int steps;
  bool from_two_feet;
  Vec<double, 2> capture;  // m, forward and to the swing side
  std::function<void(StepModel&)> spoil;
  const char* term;
  bool may_hurry = false;  // the swing time is free
};

robots::SupportPolygon::HalfPlanes rectangle(double x0, double x1, double y0, double y1) {
  Eigen::Matrix<double, 4, 2> corners;
  corners << x0, y0, x1, y0, x1, y1, x0, y1;
  return robots::SupportPolygon::hull(corners).half_planes(reach_rows);
}

// Penalised constraints of the planner are hard constraints here.
OptimalControlProblem problem_of(const LostStep& lost) {
  StepModel model;
  model.reach = rectangle(-0.25, 0.25, 0.13, 0.31);
  model.leg = rectangle(-0.35, 0.35, -0.35, 0.35);
  model.lent = 0.005;
  model.lent_rate = 0.07;
  if (lost.spoil) lost.spoil(model);
  OptimalControlProblem problem =
      push_recovery::step_problem(model, lost.steps, lost.from_two_feet);
  VectorXd start = VectorXd::Zero(push_recovery::step_states);
  start.segment<2>(2) = lost.capture;
  problem.start_at(start);
  for (int j = 0; j < static_cast<int>(problem.phases().size()); ++j) {
    PhaseDefinition& phase = problem.editable_phase(j);
    if (!lost.may_hurry && phase.name.starts_with("single"))
      phase.duration.lower = model.swing.lower;
    for (Term& term : phase.terms) term.soft.reset();
    for (PhaseDefinition::ParameterBlock& block : phase.parameters)
      if (block.name == "now") {
        push_recovery::StepNow<double> now;
        now.other << 0.0, lost.from_two_feet ? 0.15 : 0.0;
        now.swing = now.aim = Vec<double, 2>(0.0, 0.15);
        now.stride << 0.0, 0.15;
        block.value = packed(now);
      }
  }
  return problem;
}

void fix_swing(StepModel& model, double duration) {
  model.swing = exactly(duration);
  model.usual_swing = duration;
}

const LostStep lost_steps[] = {
    {"standing_beyond_the_sole", 0, false, {0.0, 0.05}, {}, "captured"},
    {"fixed_step_time_too_long",
     1,
     false,
     {0.0, 0.12},
     [](auto& m) { fix_swing(m, 0.6); },
     "swing time",
     true},
    {"pushed_beyond_reach", 1, false, {0.35, 0.3}, {}, "captured"},
    {"foot_too_slow", 1, false, {0.12, 0.0}, [](auto& m) { m.swing_speed = 0.1; }, "captured"},
    {"legs_too_short",
     1,
     false,
     {0.0, 0.06},
     [](auto& m) { m.leg = rectangle(-0.1, 0.1, -0.1, 0.05); },
     "reach of the legs"},
    {"unloading_too_slow",
     1,
     true,
     {0.25, 0.0},
     [](auto& m) { m.unloading = exactly(0.4); },
     "captured"},
};

// ---- both
// -----------------------------------------------------------------------------------------

// Checks all but the names: times, amounts (with Ipopt), and the proposed changes.
void expect_explained(const OptimalControlProblem& problem, const ShootingOptions& options,
                      const char* name, const char* term, double asked_time,
                      const std::optional<double>& amount) {
  const Explanation e = explain(problem, {.shooting = options, .time_limit = 120.0});
  std::printf("%s (%d solves, %.2f s)\n%s", name, e.solves, e.seconds, e.text().c_str());
  ASSERT_TRUE(e.is_infeasible()) << describe(e.status);
  const Explanation::Shortage& first = e.shortages.front();
  EXPECT_EQ(first.term, term);
  MultipleShooting shooting(problem, options);
  const double end = e.trajectory.end_time();
  const double time = std::isnan(asked_time) ? end : asked_time;
  EXPECT_NEAR(first.time, time, shooting.grid().nominal_length(0) + 1e-6);
  if (amount) {
    EXPECT_NEAR(first.amount, *amount, 1e-3 * *amount);
  }

  // The same program by Ipopt, from the point found and from the problem's guess.
  const VectorXd guess = shooting.initial_guess().w;
  std::vector<ElasticGroup> groups;
  for (NegotiableConstraint& asked : negotiable_constraints(shooting.editable_program(), guess))
    groups.push_back(std::move(asked.group));
  ElasticProgram elastic(shooting.nlp(), std::move(groups), guess);
  const auto ipopt = make_ipopt({.tolerance = 1e-9, .max_iterations = 1000});
  const NlpResult other = ipopt->solve(elastic, elastic.start(guess), false);
  ASSERT_TRUE(is_success(other.status)) << describe(other.status);
  EXPECT_NEAR(e.relaxation, elastic.relaxation(other.point.w), 1e-3 * e.relaxation);

  // Apply the proposed changes: solve from the problem's own guess or from the relaxed motion.
  ASSERT_FALSE(e.remedies.empty());
  for (const Explanation::Remedy& remedy : e.remedies) {
    OptimalControlProblem better = problem;
    for (const ProblemChange& change : remedy.changes) better = changed(better, change);
    MultipleShooting with(better, options);
    const auto sqp = make_native_solver({.tolerance = 1e-9});
    Solution plan = solve(with, *sqp);
    if (!plan.ok()) plan = solve(with, *sqp, with.guess_from(e.trajectory));
    EXPECT_TRUE(plan.ok() || plan.status == SolveStatus::coarse_grid)
        << remedy.text << ": " << plan.message;
  }
}

class Infeasible : public testing::TestWithParam<Spoilt> {};

TEST_P(Infeasible, NamesTermTimeAmountAndRemedy) {
  const Spoilt& spoilt = GetParam();
  const ReferenceCase& c = library_case(spoilt.id);
  OptimalControlProblem problem = c.problem();
  spoilt.spoil(problem);
  expect_explained(problem, c.options, spoilt.name, spoilt.term, spoilt.time, spoilt.amount);
}

INSTANTIATE_TEST_SUITE_P(Library, Infeasible, testing::ValuesIn(all),
                         [](const auto& instance) { return std::string(instance.param.name); });

class InfeasibleStep : public testing::TestWithParam<LostStep> {};

TEST_P(InfeasibleStep, NamesTermTimeAmountAndRemedy) {
  const LostStep& lost = GetParam();
  const OptimalControlProblem problem = problem_of(lost);
  expect_explained(problem, push_recovery::step_grid(problem), lost.name, lost.term, at_the_end,
                   std::nullopt);
}

INSTANTIATE_TEST_SUITE_P(PushRecovery, InfeasibleStep, testing::ValuesIn(lost_steps),
                         [](const auto& instance) { return std::string(instance.param.name); });

TEST(Explain, DoesNotExplainFeasibleConstraints) {
  for (const char* id : {"B02a", "B05", "B22", "E01", "C09a"}) {
    const ReferenceCase& c = library_case(id);
    const Explanation e = explain(c.problem(), {.shooting = c.options});
    EXPECT_TRUE(e.ok()) << id;
    EXPECT_FALSE(e.is_infeasible()) << id << ": " << e.text();
    EXPECT_LT(e.relaxation, 1e-6) << id;
  }
}

}  // namespace
}  // namespace saltus
