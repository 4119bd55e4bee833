// One-sided derivatives of optima with an event at a node or at another event, compared with closed
// forms and with solving again on that side.
#include "saltus/transcription/optimum_derivatives.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/core/limit_at_zero.hpp"
#include "saltus/solver/ipopt.hpp"
#include "tests/support/event_problems.hpp"

namespace saltus {
namespace {

using namespace testing_support;

const IpoptOptions tight{.tolerance = 1e-11};

OneSidedDerivative along(MultipleShooting& shooting, const std::vector<EventRate>& direction) {
  const auto solver = make_ipopt(tight);
  const Solution s = solve(shooting, *solver);
  EXPECT_TRUE(s.ok()) << s.message;
  const OneSidedDerivative d = one_sided_derivative(shooting, *solver, s, direction);
  // The problem is unchanged.
  EXPECT_NEAR(solve(shooting, *solver).cost, s.cost, 1e-12);
  return d;
}

// Slopes of secants of the optimal cost on one side, extrapolated.
double chords(MultipleShooting& shooting, const std::string& event, double side) {
  const auto solver = make_ipopt(tight);
  const double time = shooting.data().schedule.time_of(event);
  const double here = solve(shooting, *solver).cost;
  LimitAtZero limit;
  for (double d = 0.02; d > 2e-3; d *= 0.5) {
    shooting.retime(event, time + side * d);
    limit.add(VectorXd::Constant(1, (solve(shooting, *solver).cost - here) / d));
  }
  shooting.retime(event, time);
  return limit.value()[0];
}

// u acts only after the event: J = min c^2 T + (c T - 1)^2 = 1 / (1 + T), T = 1 - t_e. J has no
// kink at a node, but the program differs on either side.
TEST(OneSided, DerivativeAtANodeMatchesTheClosedForm) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.bound_input(0, exactly(0.0), Window{.to = event("impact")})
      .minimise("effort", [](const auto&, const auto&, const auto& u) { return u[0] * u[0]; })
      .minimise_at_end("short of one",
                       [](const auto&, const auto& x) { return (x[0] - 1.0) * (x[0] - 1.0); });
  OptimalControlProblem ocp("landing");
  ocp.schedule(Schedule({"before", "after"}, {{"impact", 0.4}})).start_at({0}).then(phase);
  MultipleShooting shooting(ocp.costs(CostRule::integrated), ten);
  {
    OptimumDerivatives both(shooting, solve(shooting, *make_ipopt(tight)));
    EXPECT_FALSE(both.wrt_event("impact").reliable);
  }
  for (const double side : {1.0, -1.0}) {
    const OneSidedDerivative d = along(shooting, {{"impact", side}});
    EXPECT_TRUE(d.reliable) << d.message;
    EXPECT_NEAR(d.cost, side / (1.6 * 1.6), 1e-8);
    EXPECT_LT(d.error, 1e-7);
    EXPECT_NEAR(d.first_input[0], 0.0, 1e-8);
  }
}

// The cost at the nodes is a sum whose weights depend on the event, so the slopes on the two sides
// differ.
TEST(OneSided, DerivativesAtANodeDifferAtAKink) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.bound_input(0, between(-0.5, 0.5), Window{.to = event("impact")})
      .track("state", state, Vec<double, 1>{3.0})
      .track("effort", input, Vec<double, 1>{0.2});
  MultipleShooting shooting(with_impact(phase, 0.4), ten);
  double slopes[2];
  for (const int side : {0, 1}) {
    const double sign = side == 0 ? -1.0 : 1.0;
    const OneSidedDerivative d = along(shooting, {{"impact", sign}});
    EXPECT_TRUE(d.reliable) << d.message;
    slopes[side] = sign * d.cost;
    EXPECT_NEAR(d.cost, chords(shooting, "impact", sign), 2e-6) << sign;
  }
  EXPECT_GT(std::abs(slopes[1] - slopes[0]), 1e-2);
}

// Two events at the same time. The interval between them costs 2 per second. They can separate or
// move together.
TEST(OneSided, DerivativeThroughSimultaneousEventsIsDirectional) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase
      .minimise(
          "between", [](const auto& t, const auto&) { return 0.0 * t + 2.0; },
          Window{.from = event("first"), .to = event("second")})
      .track("state", state, Vec<double, 1>{3.0})
      .track("effort", input, Vec<double, 1>{0.2});
  OptimalControlProblem ocp("two events");
  ocp.schedule(Schedule({"a", "b", "c"}, {{"first", 0.43}, {"second", 0.43}}))
      .start_at({1})
      .costs(CostRule::integrated)
      .then(phase);
  MultipleShooting shooting(ocp, ten);
  // Moving an event also moves the break of the input there, which changes the cost. The cost of
  // separation is therefore measured relative to moving both events together.
  const double together = along(shooting, {{"first", 1.0}, {"second", 1.0}}).cost;
  const OneSidedDerivative apart = along(shooting, {{"second", 1.0}});
  EXPECT_TRUE(apart.reliable) << apart.message;
  EXPECT_NEAR(apart.cost, chords(shooting, "second", 1.0), 2e-6);
  const OneSidedDerivative earlier = along(shooting, {{"first", -1.0}});
  EXPECT_TRUE(earlier.reliable) << earlier.message;
  EXPECT_NEAR(earlier.cost, chords(shooting, "first", -1.0), 2e-6);
  // Separation costs 2 per second, independent of other changes.
  const OneSidedDerivative parted = along(shooting, {{"first", -0.5}, {"second", 0.5}});
  EXPECT_NEAR(parted.cost, 0.5 * (apart.cost + earlier.cost), 1e-6);
  EXPECT_GT(apart.cost - together, 1.5);

  const OneSidedDerivative past = along(shooting, {{"first", 1.0}});
  EXPECT_FALSE(past.reliable);
  EXPECT_TRUE(std::isnan(past.cost));
  EXPECT_NE(past.message.find("cannot move in this direction"), std::string::npos) << past.message;
  EXPECT_FALSE(along(shooting, {{"first", 0.0}}).reliable);
  EXPECT_THROW(along(shooting, {{"third", 1.0}}), DefinitionError);
}

}  // namespace
}  // namespace saltus
