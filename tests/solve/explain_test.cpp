// What explain() says of small problems whose answers are known by hand, and of a controller's
// tick. Twenty problems of the library that were spoilt: tests/problems/explain_test.cpp.
#include "saltus/solve/explain.hpp"

#include <gtest/gtest.h>

#include "saltus/core/error.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/simulation/closed_loop.hpp"
#include "saltus/transcription/present_problem.hpp"

namespace saltus {
namespace {

const auto cart = [](const auto&, const auto& x, const auto& u) {
  return std::decay_t<decltype(x)>{x[1], u[0]};
};
const auto position = [](const auto&, const auto& x) { return x[0]; };
const auto pull = [](const auto&, const auto&, const auto& u) { return u; };

// At most 2 m in 2 s, from rest.
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

const Remedy* find(const Explanation& e, ProblemChange::Kind kind) {
  for (const Remedy& remedy : e.remedies)
    if (remedy.changes.size() == 1 && remedy.changes.front().kind == kind) return &remedy;
  return nullptr;
}

TEST(Explain, AmountsAndRemediesAreThoseOfTheClosedForm) {
  const Explanation e = explain(ride(4.5), exact);
  ASSERT_TRUE(e.is_infeasible());
  ASSERT_EQ(e.shortages.size(), 1u) << e.text();
  const Shortage& s = e.shortages.front();
  EXPECT_EQ(s.name(), "phase 'ride', term 'there'");
  EXPECT_EQ(s.side, ProblemChange::Side::lower);
  EXPECT_NEAR(s.amount, 2.5, 1e-5);  // rho
  EXPECT_NEAR(s.time, 2.0, 1e-12);
  EXPECT_TRUE(s.is_exact);
  // 1/2 a T^2 = 4.5: T = 3 s, or a = 2.25 m/s^2; twice 1 % and the rounding to three digits beyond.
  const Remedy* longer = find(e, ProblemChange::Kind::duration);
  ASSERT_NE(longer, nullptr) << e.text();
  EXPECT_NEAR(longer->changes.front().by, 1.0, 0.035);
  EXPECT_GE(longer->changes.front().by, 1.0);
  const Remedy* stronger = find(e, ProblemChange::Kind::input);
  ASSERT_NE(stronger, nullptr) << e.text();
  EXPECT_NEAR(stronger->changes.front().by, 1.25, 0.04);
  EXPECT_GE(stronger->changes.front().by, 1.25);
  for (const Remedy& remedy : e.remedies) EXPECT_TRUE(is_success(remedy.status)) << remedy.text;
}

TEST(Explain, NothingIsMissingWhereConstraintsCanBeMet) {
  const Explanation e = explain(ride(1.5), exact);
  EXPECT_TRUE(e.ok());
  EXPECT_FALSE(e.is_infeasible());
  EXPECT_TRUE(e.remedies.empty());
  EXPECT_EQ(e.text(), "the constraints can be met, near the guess at least\n");
}

TEST(Explain, EndsWithItsTime) {
  ExplainOptions hurried = exact;
  hurried.time_limit = 1e-9;
  const Explanation e = explain(ride(4.5), hurried);
  EXPECT_FALSE(e.ok());
  EXPECT_NE(e.text().find("not known"), std::string::npos) << e.text();
}

TEST(Explain, ATickIsExplainedWhenTheRunIsOver) {
  OptimalControlProblem problem = ride(1.5);
  RecedingHorizonController controller(MultipleShooting(problem, exact.shooting), {.period = 0.1});
  IntegratorPlant plant = nominal_plant(problem, zero_order_hold());
  plant.disturb(VectorXd{{-1.0, 0.0}});  // from there 2.5 m are asked for, and 2 m can be done
  const LoopLog log = simulate_closed_loop(controller, plant, {.duration = 0.3, .keep_unmet = 2});
  ASSERT_EQ(log.unmet.size(), 2u);
  EXPECT_EQ(log.unmet.front().time, 0.0);
  const Explanation e =
      explain(log.unmet.front().problem, {.shooting = log.unmet.front().shooting});
  ASSERT_TRUE(e.is_infeasible()) << e.text();
  EXPECT_EQ(e.shortages.front().name(), "phase 'ride', term 'there'");
  EXPECT_NEAR(e.shortages.front().amount, 0.5, 1e-5);
}

TEST(ProblemChange, MovesOneNumberAndLeavesTheOriginal) {
  const OptimalControlProblem problem = ride(1.5);
  const ProblemChange stronger{.kind = ProblemChange::Kind::input, .by = 0.5};
  const OptimalControlProblem better = changed(problem, stronger);
  EXPECT_EQ(better.phases()[0].input_bounds[0].bounds, between(-1.0, 1.5));
  EXPECT_EQ(problem.phases()[0].input_bounds[0].bounds, between(-1.0, 1.0));
  EXPECT_EQ(value_before(problem, stronger), 1.0);
  EXPECT_EQ(describe(problem, stronger),
            "with input 0 in phase 'ride' allowed up to 1.5 in place of 1");
  const ProblemChange nearer{.kind = ProblemChange::Kind::term, .name = "there", .by = -0.5};
  EXPECT_EQ(changed(problem, nearer).phases()[0].terms[2].bounds[0], exactly(1.0));
  EXPECT_THROW(changed(problem, {.kind = ProblemChange::Kind::term, .name = "ther", .by = 1.0}),
               DefinitionError);
}

}  // namespace
}  // namespace saltus
