// Inputs as functions of time between nodes, and the cost of their changes.
#include <gtest/gtest.h>

#include <limits>

#include "saltus/solver/ipopt.hpp"
#include "tests/support/event_problems.hpp"
#include "tests/support/program_derivatives.hpp"

namespace saltus {
namespace {

using namespace testing_support;

// --- shape
// ----------------------------------------------------------------------------------------

// Tracks a varying speed, with an event in the middle of an interval.
Solution solve_with(InputParametrisation parametrisation, double impact = 0.45) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.inputs(parametrisation)
      .bound_input(0, at_most(0.2), Window{.to = event("impact")})
      .minimise("tracking", [](const auto& t, const auto&, const auto& u) {
        return (u[0] - t * t) * (u[0] - t * t);
      });
  OptimalControlProblem ocp = with_impact(phase, impact);
  MultipleShooting shooting(ocp.costs(CostRule::integrated), ten);
  return solve(shooting, *make_ipopt({.tolerance = 1e-10}));
}

double gap_at(const Solution& solution, double t) {
  return std::abs(solution.trajectory.input(t + 1e-9)[0] - solution.trajectory.input(t - 1e-9)[0]);
}

TEST(InputParametrisation, PiecewiseConstantDoesNotMoveWithinAnInterval) {
  const Solution s = solve_with(InputParametrisation::piecewise_constant);
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_EQ(s.trajectory.input(0.61)[0], s.trajectory.input(0.69)[0]);
  EXPECT_NEAR(s.trajectory.input(0.65)[0], (0.343 - 0.216) / 0.3, 1e-7);  // mean of t^2
}

TEST(InputParametrisation, PiecewiseLinearMayJumpAtEveryNode) {
  const Solution s = solve_with(InputParametrisation::piecewise_linear);
  ASSERT_TRUE(s.ok()) << s.message;
  // The best line for t^2 on [a, a + h] is h^2 / 6 below the parabola at the start and at the end.
  EXPECT_NEAR(s.trajectory.input(0.6)[0], 0.36 - 0.01 / 6.0, 1e-7);
  EXPECT_NEAR(s.trajectory.input(0.7 - 1e-12)[0], 0.49 - 0.01 / 6.0, 1e-7);
}

TEST(InputParametrisation, ContinuousLinearJumpsAtEventsOnly) {
  const Solution s = solve_with(InputParametrisation::piecewise_linear_continuous);
  ASSERT_TRUE(s.ok()) << s.message;
  for (const double t : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9})
    EXPECT_LT(gap_at(s, t), 1e-7) << t;
  EXPECT_LE(s.trajectory.input(0.45 - 1e-9)[0], 0.2 + 1e-8);
  EXPECT_LT(s.trajectory.input(0.45 - 1e-9)[0], s.trajectory.input(0.45)[0]);
}

TEST(InputParametrisation, ContinuousLinearJumpsAtAnEventOnANode) {
  // At 0.6 the bound of 0.2 is far below the parabola.
  const Solution s = solve_with(InputParametrisation::piecewise_linear_continuous, 0.6);
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_GT(gap_at(s, 0.6), 0.1);
  EXPECT_LT(gap_at(s, 0.5), 1e-7);
}

TEST(InputParametrisation, BoundsHoldOverTheWholeInterval) {
  for (const InputParametrisation parametrisation :
       {InputParametrisation::piecewise_linear,
        InputParametrisation::piecewise_linear_continuous}) {
    const Solution s = solve_with(parametrisation, infinity);
    ASSERT_TRUE(s.ok()) << s.message;
    for (int i = 0; i <= 1000; ++i) EXPECT_LE(s.trajectory.input(i / 1000.0)[0], 0.2 + 1e-8);
  }
}

// 1 m in 2 s from rest to rest costs 3/4, with a force that is linear in time. A cost at the starts
// of intervals would give a zero force there and an arbitrary force between them.
TEST(InputParametrisation, LinearInputsUseTheIntegralForAnyRule) {
  const auto cart = [](const auto&, const auto& x, const auto& u) {
    return std::decay_t<decltype(x)>{x[1], u[0]};
  };
  for (const CostRule rule : {CostRule::nodes, CostRule::integrated})
    for (const InputParametrisation parametrisation :
         {InputParametrisation::piecewise_linear,
          InputParametrisation::piecewise_linear_continuous}) {
      Phase<2, 1> ride{"ride", cart, exactly(2.0)};
      ride.inputs(parametrisation)
          .track("effort", input, VectorXd::Ones(1))
          .reach("there", state, {exactly(1.0), exactly(0.0)});
      OptimalControlProblem ocp("ride");
      MultipleShooting shooting(ocp.start_at({0, 0}).then(ride).costs(rule), ten);
      const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
      ASSERT_TRUE(s.ok()) << s.message;
      EXPECT_NEAR(s.cost, 0.75, 1e-8);
      EXPECT_NE(s.method.find("costs integrated"), std::string::npos) << s.method;
    }
}

TEST(InputParametrisation, DerivativesAreExactForEveryKind) {
  for (const InputParametrisation parametrisation :
       {InputParametrisation::piecewise_constant, InputParametrisation::piecewise_linear,
        InputParametrisation::piecewise_linear_continuous})
    for (const CostRule rule : {CostRule::nodes, CostRule::integrated}) {
      Phase<1, 1> phase{
          "motion",
          [](const auto& t, const auto& x, const auto& u) { return u[0] * sin(x[0]) + t; },
          between(0.5, 2.0)};
      phase.inputs(parametrisation)
          .guess_duration(1.0)
          .minimise("cost", [](const auto& t, const auto& x, const auto& u) {
            return t * x[0] * x[0] + u[0] * u[0] * x[0];
          });
      phase.keep(
          "mixed", [](const auto& t, const auto& x, const auto& u) { return t * x[0] * u[0]; },
          at_most(3.0), Window{.to = 0.4});
      OptimalControlProblem ocp("derivatives");
      ocp.start_at({1}).then(phase).costs(rule);
      MultipleShooting shooting(ocp, {.intervals_per_phase = 4, .integrator = runge_kutta4()});
      const auto errors = derivative_errors(
          shooting.nlp(), perturbed(shooting.nlp(), shooting.initial_guess().w, 17, 0.2));
      EXPECT_LT(errors.gradient, 1e-8);  // differences of numbers of order one
      EXPECT_LT(errors.jacobian, 1e-8);
      EXPECT_LT(errors.hessian, 1e-8);
    }
}

// --- changes
// ----------------------------------------------------------------------------------------

// Cost of the program with inputs u_k = k in the intervals that are not empty.
double cost_of_ramp(MultipleShooting& shooting) {
  NlpPoint point = shooting.initial_guess();
  int count = 0;
  for (int k = 0; k < shooting.grid().intervals(0); ++k)
    point.w[shooting.layout().input(0, k)] =
        shooting.grid().interval(0, k).is_empty() ? 77.0 : count++;
  double cost = 0.0;
  EXPECT_TRUE(shooting.nlp().objective(point.w.data(), cost));
  return cost;
}

Phase<1, 1> charged() {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.penalise_change(Vec<double, 1>{2.0});
  return phase;
}

TEST(InputChange, IsTheSumOfSquaresOnAUniformGrid) {
  MultipleShooting shooting(with_impact(charged(), infinity), ten);
  EXPECT_NEAR(cost_of_ramp(shooting), 9 * 0.5 * 2.0, 1e-12);
}

TEST(InputChange, SplitIntervalIsWeightedByTheMeanLength) {
  auto phase = charged();
  phase.bound_input(0, at_most(100.0), Window{.from = event("impact")});
  MultipleShooting shooting(with_impact(phase, 0.43), ten);
  // Lengths ... 0.1 | 0.03 0.07 | 0.1 ...: three changes are next to the cut, and seven are not.
  const double around = 0.1 / 0.065 + 0.1 / 0.05 + 0.1 / 0.085;
  EXPECT_NEAR(cost_of_ramp(shooting), 7 * 1.0 + around, 1e-9);
}

TEST(InputChange, SkipsEmptySlots) {
  for (const double impact : {0.0, 0.4, 1.0, 2.0, -1.0}) {
    auto phase = charged();
    phase.bound_input(0, at_most(100.0), Window{.from = event("impact")});
    MultipleShooting shooting(with_impact(phase, impact), ten);
    EXPECT_NEAR(cost_of_ramp(shooting), 9.0, 1e-12) << impact;
  }
}

TEST(InputChange, IsNotPenalisedForMissingInputs) {
  auto phase = charged();
  phase.bound_input(0, exactly(0.0), Window{.to = event("impact")});
  MultipleShooting shooting(with_impact(phase, 0.4), ten);
  EXPECT_NEAR(cost_of_ramp(shooting), 5.0, 1e-12);  // among the six intervals after the impact
}

TEST(InputChange, UsesThePreviousInputOnceGiven) {
  MultipleShooting shooting(with_impact(charged(), infinity), ten);
  shooting.set_previous_input(Vec<double, 1>{-3.0});
  EXPECT_NEAR(cost_of_ramp(shooting), 9.0 + 9.0, 1e-12);  // |0 - (-3)|^2 is added
}

TEST(InputChange, UsesThePreviousInputAcrossAnEventAtTheStart) {
  auto phase = charged();
  phase.bound_input(0, at_most(100.0), Window{.from = event("impact")});
  MultipleShooting shooting(with_impact(phase, 0.0), ten);
  shooting.set_previous_input(Vec<double, 1>{-3.0});
  EXPECT_NEAR(cost_of_ramp(shooting), 18.0, 1e-12);
}

TEST(InputChange, UsesThePreviousInputOnlyIfTheFirstExists) {
  auto phase = charged();
  phase.bound_input(0, exactly(0.0), Window{.to = event("impact")});
  MultipleShooting shooting(with_impact(phase, 0.4), ten);
  shooting.set_previous_input(Vec<double, 1>{-3.0});
  EXPECT_NEAR(cost_of_ramp(shooting), 5.0, 1e-12);
}

TEST(InputChange, IgnoresAMissingPreviousInput) {
  auto phase = charged();
  phase.bound_input(0, exactly(0.0), Window{.to = event("impact")});
  MultipleShooting shooting(with_impact(phase, 0.0), ten);  // it is being created now
  shooting.set_previous_input(Vec<double, 1>{std::numeric_limits<double>::quiet_NaN()});
  EXPECT_NEAR(cost_of_ramp(shooting), 9.0, 1e-12);
}

TEST(InputChange, DerivativesAreExact) {
  auto phase = charged();
  phase.bound_input(0, at_most(100.0), Window{.from = event("impact")});
  MultipleShooting shooting(with_impact(phase, 0.43), ten);
  shooting.set_previous_input(Vec<double, 1>{-3.0});
  const auto errors =
      derivative_errors(shooting.nlp(), perturbed(shooting.nlp(), shooting.initial_guess().w, 23));
  EXPECT_LT(errors.gradient, 1e-8);
  EXPECT_LT(errors.hessian, 1e-8);
}

}  // namespace
}  // namespace saltus
