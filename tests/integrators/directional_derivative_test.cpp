// Derivatives of the flow along a direction: for two simultaneous events, for a guard that reads an
// input, and for a grazed guard.
#include "saltus/model/integrator.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/model/automaton.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

// A point crosses x = 0 and y = 0. Between the crossings, z rises by 1 + x^2 per second if x was
// first, and by 3 + y if y was first.
Automaton<3> corner() {
  const auto rate = [](auto f) {
    return [f](const auto& t, const auto& x) {
      auto v = x.eval();
      v[0] = 0.0 * t + 1.0;
      v[1] = 0.0 * t + 1.0;
      v[2] = 0.0 * t + f(x);
      return v;
    };
  };
  const auto none = [](const auto& x) { return 0.0 * x[0]; };
  const auto x = [](const auto&, const auto& s) { return s[0]; };
  const auto y = [](const auto&, const auto& s) { return s[1]; };
  Automaton<3> a;
  a.mode("before", rate(none))
      .mode("x first", rate([](const auto& s) { return 1.0 + s[0] * s[0]; }))
      .mode("y first", rate([](const auto& s) { return 3.0 + s[1]; }))
      .mode("after", rate(none))
      .event("x", "before", "x first", x, Crossing::rising)
      .event("y then", "x first", "after", y, Crossing::rising)
      .event("y", "before", "y first", y, Crossing::rising)
      .event("x then", "y first", "after", x, Crossing::rising);
  return a;
}

IntervalProblem interval(const SwitchingSystem& system, Arguments sizes) {
  IntervalProblem problem;
  problem.arguments = sizes;
  problem.switching = system;
  problem.dynamics = system.modes.front().dynamics;
  return problem;
}

TEST(DirectionalDerivative, ThroughSimultaneousEventsDependsOnTheDirection) {
  // The step errors of CVODES limit the accuracy of its extrapolation.
  for (const IntegratorChoice& scheme :
       {runge_kutta8({.steps = 4}), cvodes({.tolerance = 1e-11})}) {
    const auto flow = scheme->make(interval(corner().system(), {3, 0, 0}));
    VectorXd w(flow->arguments().size());
    w << -0.5, -0.5, 0.0, 0.0, 1.0;
    const auto slope = [&](double dx, double dy) {
      VectorXd direction = VectorXd::Zero(w.size());
      direction.head(2) << dx, dy;
      const DirectionalDerivative d = directional_derivative(*flow, w, direction);
      EXPECT_TRUE(d.exists) << d.message;
      return d.value[2];
    };
    // x is ahead by dx - dy, which is also the time between the events in seconds.
    EXPECT_NEAR(slope(1.0, 0.0), 1.0, 1e-7);
    EXPECT_NEAR(slope(-1.0, 0.0), 3.0, 1e-7);
    EXPECT_NEAR(slope(0.0, 1.0), 3.0, 1e-7);
    EXPECT_NEAR(slope(0.0, -1.0), 1.0, 1e-7);
    EXPECT_NEAR(slope(2.0, 0.5), 1.5, 1e-7);
    EXPECT_NEAR(slope(0.5, 2.0), 4.5, 1e-7);
  }
}

// A ball thrown up to a ceiling that it only touches: the derivative exists away from the ceiling
// only.
TEST(DirectionalDerivative, ExistsOnTheMissingSideOfAGrazedGuard) {
  Automaton<2> ball;
  const auto fall = [](const auto& t, const auto& x) {
    auto v = x.eval();
    v[0] = x[1];
    v[1] = 0.0 * t - 2.0;
    return v;
  };
  ball.mode("flight", fall)
      .event(
          "ceiling", "flight", "flight", [](const auto&, const auto& x) { return x[0] - 1.0; },
          Crossing::rising,
          [](const auto&, const auto& x) {
            auto after = x.eval();
            after[1] = -0.5 * x[1];
            return after;
          });
  const auto flow = runge_kutta8({.steps = 2})->make(interval(ball.system(), {2, 0, 0}));
  VectorXd w(flow->arguments().size());
  w << 0.0, 2.0, 0.0, 1.5;  // the apex is at 1
  VectorXd up = VectorXd::Zero(w.size());
  up[1] = 1.0;
  const DirectionalDerivative slower = directional_derivative(*flow, w, -up);
  EXPECT_TRUE(slower.exists) << slower.message;
  EXPECT_NEAR(slower.value[0], -1.5, 1e-9);
  EXPECT_NEAR(slower.value[1], -1.0, 1e-9);
  const DirectionalDerivative faster = directional_derivative(*flow, w, up);
  EXPECT_FALSE(faster.exists);
  EXPECT_TRUE(std::isnan(faster.value[0]));
  EXPECT_NE(faster.message.find("grazes a guard"), std::string::npos) << faster.message;
}

// The guard reads an input: the event at x = u moves with u. x' = 1 below, 4 above.
TEST(DirectionalDerivative, FollowsAnInputInTheGuard) {
  Automaton<1, 1> relay;
  relay.mode("slow", [](const auto& t, const auto&) { return 0.0 * t + 1.0; })
      .mode("fast", [](const auto& t, const auto&) { return 0.0 * t + 4.0; })
      .event(
          "reached", "slow", "fast",
          [](const auto&, const auto& x, const auto& u) { return x[0] - u[0]; }, Crossing::rising);
  const auto flow = runge_kutta4({.steps = 3})->make(interval(relay.system(), {1, 1, 0}));
  VectorXd w(flow->arguments().size());
  w << 0.0, 0.4, 0.0, 1.0;  // x(0), u, t0, h
  VectorXd later = VectorXd::Zero(w.size());
  later[1] = 1.0;
  // x(1) = u + 4 (1 - u): inside the interval both sides agree with the Jacobian.
  for (const double sign : {1.0, -1.0}) {
    const DirectionalDerivative d = directional_derivative(*flow, w, sign * later);
    EXPECT_TRUE(d.exists) << d.message;
    EXPECT_NEAR(d.value[0], -3.0 * sign, 1e-9);
  }
  // At the end of the interval, only an earlier event counts.
  w[1] = 1.0;
  const DirectionalDerivative earlier = directional_derivative(*flow, w, -later);
  EXPECT_TRUE(earlier.exists) << earlier.message;
  EXPECT_NEAR(earlier.value[0], 3.0, 1e-9);
  const DirectionalDerivative never = directional_derivative(*flow, w, later);
  EXPECT_TRUE(never.exists) << never.message;
  EXPECT_NEAR(never.value[0], 0.0, 1e-9);
  EXPECT_THROW(directional_derivative(*flow, w.head(2), later), DefinitionError);
}

// The mode has memory: for temperatures between 1 and 2, the state stores it.
TEST(Hysteresis, IsStoredInAState) {
  const auto towards = [](double goal) {
    return [goal](const auto&, const auto& x) {
      auto v = x.eval();
      v[0] = goal - x[0];
      v[1] = 0.0;
      return v;
    };
  };
  Automaton<2> heater;
  heater.mode("heating", towards(3.0))
      .mode("idle", towards(0.0))
      .store_mode_in(1)
      .event(
          "warm", "heating", "idle", [](const auto&, const auto& x) { return x[0] - 2.0; },
          Crossing::rising)
      .event(
          "cold", "idle", "heating", [](const auto&, const auto& x) { return x[0] - 1.0; },
          Crossing::falling);
  for (const IntegratorChoice& scheme :
       {runge_kutta8({.steps = 4}), cvodes({.tolerance = 1e-11})}) {
    const auto flow = scheme->make(interval(heater.system(), {2, 0, 0}));
    VectorXd w(flow->arguments().size()), end(2);
    MatrixXd jacobian(2, w.size());
    const auto run = [&](double x, double mode, double length) {
      w << x, mode, 0.0, length;
      EXPECT_EQ(flow->jacobian(w.data(), end.data(), jacobian), IntegrationStatus::success)
          << flow->failure();
    };
    run(1.5, 0.0, 0.1);  // continues heating
    EXPECT_NEAR(end[0], 3.0 - 1.5 * std::exp(-0.1), 1e-9);
    EXPECT_EQ(end[1], 0.0);
    EXPECT_EQ(jacobian(1, 1), 1.0);
    run(1.5, 1.0, 0.1);  // continues cooling
    EXPECT_NEAR(end[0], 1.5 * std::exp(-0.1), 1e-9);
    EXPECT_EQ(end[1], 1.0);
    run(1.5, 0.0, std::log(1.5) + 0.2);  // warm after ln 1.5, then cools
    EXPECT_NEAR(end[0], 2.0 * std::exp(-0.2), 1e-9);
    EXPECT_EQ(end[1], 1.0);
    EXPECT_EQ(jacobian(1, 1), 0.0);
    EXPECT_EQ(jacobian(0, 1), 0.0);
    // The event comes earlier by dx / 1.5, and so do the events that follow.
    EXPECT_NEAR(jacobian(0, 0), -2.0 * std::exp(-0.2) / 1.5, 1e-8);
  }
}

TEST(Hysteresis, RejectsInvalidDefinitions) {
  const auto drift = [](const auto&, const auto& x) { return x; };
  const auto guard = [](const auto&, const auto& x) { return x[0]; };
  const auto message = [](const Automaton<2>& a) -> std::string {
    return error_of<DefinitionError>([&] {
      runge_kutta4()->make(interval(a.system(), {2, 0, 0}));
    });
  };
  Automaton<2> far, moving, sliding;
  far.mode("a", drift).mode("b", drift).store_mode_in(2);
  far.event("e", "a", "b", guard, Crossing::rising);
  EXPECT_NE(message(far).find("stored in state 2, but there are 2 states"), std::string::npos)
      << message(far);
  moving.mode("a", drift).mode("b", drift).store_mode_in(1);
  moving.event("e", "a", "b", guard, Crossing::rising);
  EXPECT_NE(message(moving).find("mode 'a': state 1 stores the mode"), std::string::npos)
      << message(moving);
  const auto push = [](const auto& t, const auto& x) {
    auto v = x.eval();
    v[0] = 0.0 * t + 1.0;
    v[1] = 0.0;
    return v;
  };
  sliding.mode("a", push).mode("b", push).store_mode_in(1).surface("s", "a", "b", guard);
  EXPECT_NE(message(sliding).find("use a separate guard for each direction"), std::string::npos)
      << message(sliding);
}

}  // namespace
}  // namespace saltus
