// Results of explain() for small problems with known answers and for the tick of a controller.
// tests/problems/explain_test.cpp covers twenty library problems with deliberate errors.
#include "saltus/solve/explain.hpp"

#include <gtest/gtest.h>

#include "saltus/core/error.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/simulation/closed_loop.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {
namespace {

const auto cart = [](const auto&, const auto& x, const auto& u) {
  return std::decay_t<decltype(x)>{x[1], u[0]};
};
const auto position = [](const auto&, const auto& x) { return x[0]; };
const auto pull = [](const auto&, const auto&, const auto& u) { return u; };

// At most 2 m can be reached in 2 s from rest.
OptimalControlProblem ride(double distance) {
  Phase<2, 1> phase{"ride", cart, exactly(2.0)};
  phase.bound_input(0, between(-1.0, 1.0))
      .track("effort", pull, VectorXd::Ones(1))
      .keep("wall", position, at_most(10.0))
      .reach("there", position, exactly(distance));
  OptimalControlProblem problem("ride");
  problem.start_at({0.0, 0.0}).then(phase);
  return problem;
}
const ExplainOptions exact{
    .shooting = {.intervals_per_phase = 20, .integrator = zero_order_hold()}};

const Explanation::Remedy* find(const Explanation& e, ProblemChange::Kind kind) {
  for (const Explanation::Remedy& remedy : e.remedies)
    if (remedy.changes.size() == 1 && remedy.changes.front().kind == kind) return &remedy;
  return nullptr;
}

// A result for a non-convex problem is valid near the guess only, and events make it jump.
TEST(Explain, ReportsWhereItSearched) {
  const auto spring = [](const auto&, const auto& x, const auto& u) {
    return std::decay_t<decltype(x)>{x[1], u[0] - x[0] * x[0] * x[0]};
  };
  for (const bool has_events : {false, true}) {
    Phase<2, 1> phase{"pull", spring, exactly(1.0)};
    phase.bound_input(0, between(-1.0, 1.0)).reach("there", position, exactly(3.0));
    if (has_events)
      phase.on(
          "wall", [](const auto&, const auto& x) { return x[0] - 9.0; }, Crossing::rising,
          [](const auto&, const auto& x) {
            return std::decay_t<decltype(x)>{x[0], -x[1]};
          });
    OptimalControlProblem problem("pull");
    const std::string text =
        explain(problem.start_at({0.0, 0.0}).then(phase), {.remedies = 0}).text();
    EXPECT_NE(text.find("term 'there' was not met near the guess: "), std::string::npos) << text;
    EXPECT_EQ(text.find("its events make the problem discontinuous") != std::string::npos,
              has_events)
        << text;
  }
}

TEST(Explain, AmountsAndRemediesMatchTheClosedForm) {
  const Explanation e = explain(ride(4.5), exact);
  ASSERT_TRUE(e.is_infeasible());
  ASSERT_EQ(e.shortages.size(), 1u) << e.text();
  const Explanation::Shortage& s = e.shortages.front();
  EXPECT_EQ(s.name(), "phase 'ride', term 'there'");
  EXPECT_EQ(s.side, ProblemChange::Side::lower);
  EXPECT_NEAR(s.amount, 2.5, 1e-5);  // rho
  EXPECT_NEAR(s.time, 2.0, 1e-12);
  EXPECT_TRUE(s.is_exact);
  EXPECT_NE(e.text().find("'there' cannot be met: 2.5 too little"), std::string::npos) << e.text();
  // 1/2 a T^2 = 4.5: T = 3 s, or a = 2.25 m/s^2. The suggestion exceeds this by 1 % twice and by
  // rounding to three digits.
  const Explanation::Remedy* longer = find(e, ProblemChange::Kind::duration);
  ASSERT_NE(longer, nullptr) << e.text();
  EXPECT_NEAR(longer->changes.front().by, 1.0, 0.035);
  EXPECT_GE(longer->changes.front().by, 1.0);
  const Explanation::Remedy* stronger = find(e, ProblemChange::Kind::input);
  ASSERT_NE(stronger, nullptr) << e.text();
  EXPECT_NEAR(stronger->changes.front().by, 1.25, 0.04);
  EXPECT_GE(stronger->changes.front().by, 1.25);
  for (const Explanation::Remedy& remedy : e.remedies)
    EXPECT_TRUE(is_success(remedy.status)) << remedy.text;
}

// The same ride in metres and in units of ten micrometres, without nominal magnitudes.
TEST(Explain, ShortagesAreIndependentOfUnits) {
  for (const double unit : {1.0, 1e-5})
    for (const double distance : {1.5, 4.5}) {
      Phase<2, 1> phase{"ride", cart, exactly(2.0)};
      phase.bound_input(0, between(-unit, unit))
          .track("effort", pull, VectorXd::Ones(1))
          .reach("there", position, exactly(distance * unit));
      OptimalControlProblem problem("ride");
      problem.start_at({0.0, 0.0}).then(phase);
      const Explanation e = explain(problem, exact);
      EXPECT_EQ(e.is_infeasible(), distance > 2.0) << unit << ", " << distance << "\n" << e.text();
      if (!(distance > 2.0)) continue;
      ASSERT_EQ(e.shortages.size(), 1u) << e.text();
      EXPECT_NEAR(e.shortages.front().amount / unit, 2.5, 1e-3);
    }
}

TEST(Explain, FeasibleProblemHasNoShortage) {
  const Explanation e = explain(ride(1.5), exact);
  EXPECT_TRUE(e.ok());
  EXPECT_FALSE(e.is_infeasible());
  EXPECT_TRUE(e.remedies.empty());
  EXPECT_EQ(e.text(), "the constraints can be met near the guess\n");
}

// The first node after the start requires 0.1 m/s. A longer ride has that node later, and would not
// help on an equally fine grid.
TEST(Explain, MovingNodesIsNoRemedy) {
  Phase<2, 1> phase{"ride", cart, exactly(2.0)};
  phase.bound_input(0, between(-1.0, 1.0))
      .keep(
          "speed", [](const auto&, const auto& x) { return x[1]; }, exactly(0.2));
  OptimalControlProblem problem("ride");
  problem.start_at({0.0, 0.0}).then(phase);
  const Explanation e = explain(problem, exact);
  ASSERT_TRUE(e.is_infeasible());
  EXPECT_NE(find(e, ProblemChange::Kind::start), nullptr) << e.text();
  EXPECT_EQ(find(e, ProblemChange::Kind::duration), nullptr) << e.text();
}

// Data such as a frequency or a mass stay positive if they were positive.
TEST(Explain, DataKeepTheirSign) {
  Phase<2, 1, 1> phase{"ride",
                       [](const auto&, const auto& x, const auto& u, const auto& p) {
                         return std::decay_t<decltype(x)>{x[1], u[0] - 0.1 * p[0]};
                       },
                       exactly(2.0)};
  phase.data("drag", VectorXd::Ones(1))
      .bound_input(0, between(-1.0, 1.0))
      .reach("there", position, exactly(4.5));
  OptimalControlProblem problem("ride");
  problem.start_at({0.0, 0.0}).then(phase);
  const Explanation e = explain(problem, exact);  // a drag of -11.5 would be enough
  ASSERT_TRUE(e.is_infeasible());
  EXPECT_EQ(find(e, ProblemChange::Kind::parameter), nullptr) << e.text();
}

TEST(Explain, RespectsItsTimeLimit) {
  ExplainOptions hurried = exact;
  hurried.time_limit = 1e-9;
  const Explanation e = explain(ride(4.5), hurried);
  EXPECT_FALSE(e.ok());
  EXPECT_NE(e.text().find("is unknown"), std::string::npos) << e.text();
}

TEST(Explain, ExplainsATickAfterTheRun) {
  OptimalControlProblem problem = ride(1.5);
  RecedingHorizonController controller(MultipleShooting(problem, exact.shooting), {.period = 0.1});
  IntegratorPlant plant = nominal_plant(problem, zero_order_hold());
  plant.disturb(VectorXd{{-1.0, 0.0}});  // from there 2.5 m are required, and 2 m are feasible
  const LoopLog log = simulate_closed_loop(controller, plant, {.duration = 0.3, .keep_unmet = 2});
  ASSERT_EQ(log.unmet.size(), 2u);
  EXPECT_EQ(log.unmet.front().time, 0.0);
  const Explanation e =
      explain(log.unmet.front().problem, {.shooting = log.unmet.front().shooting});
  ASSERT_TRUE(e.is_infeasible()) << e.text();
  EXPECT_EQ(e.shortages.front().name(), "phase 'ride', term 'there'");
  EXPECT_NEAR(e.shortages.front().amount, 0.5, 1e-5);
}

// At most 2 m in 2 s. The minimum-effort input to reach d < 4/3 m is u = lambda (T - t) with lambda
// = 3 d / T^3. This lambda is the least weight of an exact penalty.
OptimalControlProblem soft_ride(double distance, Penalty penalty) {
  Phase<2, 1> phase{"ride", cart, exactly(2.0)};
  phase.bound_input(0, between(-1.0, 1.0))
      .track("effort", pull, VectorXd::Ones(1))
      .reach("there", position, exactly(distance), std::move(penalty));
  OptimalControlProblem problem("soft ride");
  problem.start_at({0.0, 0.0}).then(phase);
  return problem;
}

TEST(ExplainSoftTerms, InfeasibleTermIsReportedWithItsRemedy) {
  const Explanation e = explain(soft_ride(4.5, soft("there", 100.0)), exact);
  EXPECT_FALSE(e.is_infeasible());
  ASSERT_EQ(e.gives_way.size(), 1u) << e.text();
  const Explanation::SoftShortage& s = e.gives_way.front();
  EXPECT_EQ(s.missed.name(), "phase 'ride', term 'there'");
  EXPECT_EQ(s.missed.side, ProblemChange::Side::lower);
  EXPECT_NEAR(s.missed.amount, 2.5, 1e-6);
  EXPECT_NEAR(s.missed.time, 2.0, 1e-12);
  EXPECT_NEAR(s.price, 250.0, 1e-4);
  ASSERT_TRUE(s.least);
  EXPECT_NEAR(*s.least, 2.5, 1e-5);
  EXPECT_FALSE(s.cost_if_held);
  const Explanation::Remedy* longer = find(e, ProblemChange::Kind::duration);
  ASSERT_NE(longer, nullptr) << e.text();
  EXPECT_NEAR(longer->changes.front().by, 1.0, 0.035);
  EXPECT_NE(e.text().find("it cannot hold: at least 2.5 is missing\nit would hold with"),
            std::string::npos)
      << e.text();
}

TEST(ExplainSoftTerms, FeasibleTermIsReportedWithItsPriceAndWeight) {
  const Explanation e = explain(soft_ride(1.2, soft("there", 0.3)), exact);
  ASSERT_EQ(e.gives_way.size(), 1u) << e.text();
  const Explanation::SoftShortage& s = e.gives_way.front();
  constexpr double grid = 1e-3;             // error of the zero-order hold on 20 intervals
  EXPECT_NEAR(s.missed.amount, 0.4, grid);  // 0.8 m is reached
  EXPECT_NEAR(s.price, 0.12, grid);
  ASSERT_TRUE(s.least && s.cost_if_held && s.weight_that_holds);
  EXPECT_EQ(*s.least, 0.0);
  EXPECT_NEAR(e.cost, 0.24, grid);
  EXPECT_NEAR(*s.cost_if_held, 0.27, grid);
  EXPECT_EQ(e.gives_way_to, "phase 'ride', 'effort'");
  EXPECT_NEAR(*s.weight_that_holds, 1.02 * 0.45, 0.002);  // rounded up to three digits
  EXPECT_TRUE(e.remedies.empty());
}

TEST(ExplainSoftTerms, NamesTheTermThatWins) {
  OptimalControlProblem problem = soft_ride(1.0, soft("there", 1.0));
  Term wall = problem.phases()[0].terms[1];
  wall.name = "wall";
  wall.bounds = {at_most(0.5)};
  wall.soft = soft("wall", 50.0);
  problem.editable_phase(0).terms.push_back(wall);
  const Explanation e = explain(problem, exact);
  ASSERT_EQ(e.gives_way.size(), 1u) << e.text();
  EXPECT_EQ(e.gives_way.front().missed.term, "there");
  EXPECT_NEAR(e.gives_way.front().missed.amount, 0.5, 1e-6);
  EXPECT_EQ(e.gives_way_to, "phase 'ride', 'wall'") << e.text();
}

TEST(ExplainSoftTerms, QuadraticPenaltyIsViolatedForAnyWeight) {
  const Explanation e = explain(soft_ride(1.2, soft("there", 1.0, Penalty::L2)), exact);
  ASSERT_EQ(e.gives_way.size(), 1u) << e.text();
  EXPECT_TRUE(e.gives_way.front().cost_if_held);
  EXPECT_FALSE(e.gives_way.front().weight_that_holds);
}

TEST(ExplainSoftTerms, SatisfiedTermIsNotReported) {
  const Explanation e = explain(soft_ride(1.2, soft("there", 10.0)), exact);
  EXPECT_TRUE(e.gives_way.empty()) << e.text();
  EXPECT_EQ(e.text(), "the constraints can be met near the guess\n");
}

TEST(ProblemChange, ChangesOneNumberOfACopy) {
  const OptimalControlProblem problem = ride(1.5);
  const ProblemChange stronger{.kind = ProblemChange::Kind::input, .by = 0.5};
  const OptimalControlProblem better = changed(problem, stronger);
  EXPECT_EQ(better.phases()[0].input_bounds[0].bounds, between(-1.0, 1.5));
  EXPECT_EQ(problem.phases()[0].input_bounds[0].bounds, between(-1.0, 1.0));
  EXPECT_EQ(value_before(problem, stronger), 1.0);
  EXPECT_EQ(describe(problem, stronger),
            "with input 0 in phase 'ride' allowed up to 1.5 instead of 1");
  const ProblemChange nearer{.kind = ProblemChange::Kind::term, .name = "there", .by = -0.5};
  EXPECT_EQ(changed(problem, nearer).phases()[0].terms[2].bounds[0], exactly(1.0));
  EXPECT_THROW(changed(problem, {.kind = ProblemChange::Kind::term, .name = "ther", .by = 1.0}),
               DefinitionError);
}

// One bound serves both rows of a link. The change affects only the selected row.
TEST(ProblemChange, ChangesOneRowOfASharedLinkBound) {
  Phase<2, 1> drive{"drive",
                    [](const auto&, const auto& x, const auto& u) {
                      return std::decay_t<decltype(x)>{x[1], u[0]};
                    },
                    exactly(1.0)};
  OptimalControlProblem problem("drive");
  problem.start_at({0, 0}).then(drive).link(
      "stands", [](const auto& end) { return end.x; }, exactly(0.0), end_of(drive));
  const OptimalControlProblem moved = changed(
      problem, {.kind = ProblemChange::Kind::link, .name = "stands", .component = 1, .by = 2.0});
  EXPECT_EQ(moved.links()[0].limits.bounds, (std::vector<Bounds>{exactly(0.0), exactly(2.0)}));
}

}  // namespace
}  // namespace saltus
