// Difficult events: tangency, two events in one step, starts and ends on a guard, sliding on moving
// surfaces, sequences of modes. Failures report the time, mode and event.
#include <random>
#include <stdexcept>

#include "saltus/core/error.hpp"
#include "saltus/integrators/hybrid_integrator.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/simulate.hpp"
#include "saltus/integrators/sundials.hpp"
#include "tests/integrators/hybrid_problems.hpp"
#include "tests/integrators/support.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus {
namespace {

using namespace test;

class HybridEdges : public HybridSchemeTest {};
INSTANTIATE_TEST_SUITE_P(Schemes, HybridEdges,
                         ::testing::Values(HybridScheme{"adams", cvodes(tight_options)},
                                           HybridScheme{"rk4", runge_kutta4({.steps = 1})},
                                           HybridScheme{"rk8", runge_kutta8({.steps = 7})},
                                           HybridScheme{"radau5",
                                                        radau_iia({.stages = 3, .steps = 2})}),
                         [](const auto& param) { return param.param.name; });

// A tank that empties slowly and an independent wheel that turns fast.
TEST_P(HybridEdges, SlowEventWithFastStatesIsNotGrazing) {
  for (const double fast : {1.0, 1e2, 1e4, 1e6})
    for (const double slow : {1e-3, 1e-5, 1e-7}) {
      const auto field = [fast, slow](const auto&, const auto& x) {
        return std::decay_t<decltype(x)>{-slow + 0.0 * x[0], fast + 0.0 * x[1]};
      };
      Automaton<2> system;
      system.mode("run", field)
          .mode("rest", field)
          .event(
              "empty", "run", "rest", [](const auto&, const auto& x) { return x[0] - 0.5; },
              Crossing::falling);
      const HybridSimulation sim =
          run(hybrid_problem(system), vec({0.5 + 0.5 * slow, 0.0}), vec({0.0, 1.0}));
      ASSERT_EQ(sim.status, IntegrationStatus::success) << fast << ' ' << slow << sim.message;
      ASSERT_EQ(sim.events.size(), 1u) << fast << ' ' << slow;
      EXPECT_NEAR(sim.events[0].time, 0.5, 1e-15 / slow + 1e-12);  // rounding of 0.5
      // If the start is on the guard, the event happens immediately.
      const HybridSimulation at_once =
          run(hybrid_problem(system), vec({0.5, 0.0}), vec({0.0, 1.0}), VectorXd(), "run");
      EXPECT_EQ(at_once.status, IntegrationStatus::success) << at_once.message;
    }
}

// A ball that bounces once. On the ground, its height has the rounding error of the flight.
TEST_P(HybridEdges, FindsAGuardAfterLargeStates) {
  Automaton<2> system;
  const auto fall = [](const auto&, const auto& x) {
    return std::decay_t<decltype(x)>{x[1], -10.0 + 0.0 * x[0]};
  };
  const auto bounce = [](const auto&, const auto& x) {
    return std::decay_t<decltype(x)>{x[0], -0.8 * x[1]};
  };
  system.mode("flight", fall)
      .event(
          "impact", "flight", "flight", [](const auto&, const auto& x) { return x[0]; },
          Crossing::falling, bounce);
  const IntervalProblem problem = hybrid_problem(system);
  std::mt19937 random(1);
  std::uniform_real_distribution<double> factor(0.5, 1.5);
  for (double scale = 1.0; scale < 2e6; scale *= 10.0)
    for (int i = 0; i < 50; ++i) {
      const double height = scale * factor(random), impact = std::sqrt(0.2 * height);
      const HybridSimulation sim =
          run(problem, vec({height, 0.0}), vec({0.0, 0.5 * impact, 1.1 * impact, 1.5 * impact}));
      ASSERT_EQ(sim.status, IntegrationStatus::success) << height << " m: " << sim.message;
      ASSERT_EQ(sim.events.size(), 1u) << height;
      EXPECT_NEAR(sim.events[0].time, impact, 1e-9 * impact);
    }
}

// x = (height, speed, number of visits above the guard): a throw whose apex exceeds `level`.
IntervalProblem thrown(double level) {
  Automaton<3> system;
  const auto fall = [](const auto&, const auto& x) {
    return std::decay_t<decltype(x)>{x[1], -10.0 + 0.0 * x[2], 0.0 * x[2]};
  };
  const auto height = [level](const auto&, const auto& x) { return x[0] - level; };
  system.mode("low", fall)
      .mode("high", fall)
      .event("up", "low", "high", height, Crossing::rising,
             [](const auto&, const auto& x) {
               return std::decay_t<decltype(x)>{x[0], x[1], x[2] + 1.0};
             })
      .event("down", "high", "low", height, Crossing::falling);
  return hybrid_problem(system);
}

TEST_P(HybridEdges, FindsTwoCrossingsWithinOneStep) {
  // v0 = 5: the apex is 1.25 at t = 0.5, above 1.2499 for 9 ms only
  const HybridSimulation sim = run(thrown(1.2499), vec({0.0, 5.0, 0.0}), vec({0.0, 0.8}));
  ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
  ASSERT_EQ(sim.events.size(), 2u);
  const double half = std::sqrt(2.0 * 1e-4 / 10.0);
  EXPECT_NEAR(sim.events[0].time, 0.5 - half, 1e-10);
  EXPECT_NEAR(sim.events[1].time, 0.5 + half, 1e-10);
  EXPECT_NEAR(sim.states(2, 1), 1.0, 1e-14);
  // An apex just below the guard gives no event.
  const HybridSimulation below = run(thrown(1.2501), vec({0.0, 5.0, 0.0}), vec({0.0, 0.8}));
  ASSERT_EQ(below.status, IntegrationStatus::success) << below.message;
  EXPECT_TRUE(below.events.empty());
}

// An interval of length zero is the identity. If the state is behind a guard, the event happens
// once, in the next interval.
TEST_P(HybridEdges, IntervalOfZeroLengthHasNoEvents) {
  const HybridSimulation sim =
      run(thrown(0.3), vec({0.5, 5.0, 0.0}), vec({0.0, 0.0, 0.01}), VectorXd(), "low");
  ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
  EXPECT_EQ(sim.events.size(), 1u);
  EXPECT_EQ(sim.states(2, 1), 0.0);
  EXPECT_NEAR(sim.states(2, 2), 1.0, 1e-14);
}

// After an event, the flow of the old mode is irrelevant. A second guard that grazes there, or has
// no value there, has no effect.
TEST_P(HybridEdges, FailureBehindAnEventIsNotReached) {
  const auto ahead = [](const auto&, const auto& x) {
    return std::decay_t<decltype(x)>{1.0 + 0.0 * x[0]};
  };
  const auto leaves = [](const auto&, const auto& x) { return x[0] - 0.3; };
  const auto grazes = [](const auto&, const auto& x) { return -(x[0] - 0.31) * (x[0] - 0.31); };
  const auto ends = [](const auto&, const auto& x) {
    using std::sqrt;
    return -sqrt(0.33 - x[0]);
  };
  for (const bool is_first : {true, false}) {
    Automaton<1> system;
    system.mode("here", ahead).mode("there", ahead).mode("nowhere", ahead);
    if (is_first) system.event("leaves", "here", "there", leaves, Crossing::rising);
    system.event("grazes", "here", "nowhere", grazes, Crossing::rising)
        .event("ends", "here", "nowhere", ends, Crossing::rising);
    if (!is_first) system.event("leaves", "here", "there", leaves, Crossing::rising);
    const HybridSimulation sim =
        run(hybrid_problem(system), vec({0.0}), vec({0.0, 1.0}), VectorXd(), "here");
    ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
    ASSERT_EQ(sim.events.size(), 1u);
    EXPECT_NEAR(sim.events[0].time, 0.3, 1e-11);
    EXPECT_NEAR(sim.states(0, 1), 1.0, 1e-11);
  }
}

TEST_P(HybridEdges, GrazingIsReported) {
  const HybridSimulation sim = run(thrown(1.25), vec({0.0, 5.0, 0.0}), vec({0.0, 0.8}));
  EXPECT_EQ(sim.status, IntegrationStatus::grazing) << sim.message;
  EXPECT_NE(sim.message.find("t = 0.5"), std::string::npos) << sim.message;
  EXPECT_NE(sim.message.find("mode 'low', event 'up'"), std::string::npos) << sim.message;
}

TEST_P(HybridEdges, HandlesAStartOnAGuard) {
  const VectorXd p = vec({9.81, 0.8}), times = vec({0.0, 0.3});
  // Leaving the guard is not an event. Moving into it is an immediate event. Resting on it is
  // undecided.
  const HybridSimulation leaves = run(bouncing_ball(), vec({0.0, 2.0}), times, p);
  ASSERT_EQ(leaves.status, IntegrationStatus::success) << leaves.message;
  EXPECT_TRUE(leaves.events.empty());
  const HybridSimulation hits = run(bouncing_ball(), vec({0.0, -2.5}), times, p);
  ASSERT_EQ(hits.status, IntegrationStatus::success) << hits.message;
  ASSERT_EQ(hits.events.size(), 1u);
  EXPECT_EQ(hits.events[0].time, 0.0);
  EXPECT_LE((hits.states.col(1) - leaves.states.col(1)).cwiseAbs().maxCoeff(), 1e-12);
  // d x+ / d x- is the saltation matrix there: Xi21 = -(1 + e) g / v.
  EXPECT_NEAR(hits.derivative(1, 0), 1.8 * 9.81 / 2.5, 1e-9);
  const HybridSimulation rests = run(bouncing_ball(), vec({0.0, 0.0}), times, p);
  EXPECT_EQ(rests.status, IntegrationStatus::ambiguous_start);
  EXPECT_NE(rests.message.find("t = 0 s"), std::string::npos) << rests.message;
}

// Whether a state is on a guard depends on the size of its coordinates, not on their sign.
TEST_P(HybridEdges, HandlesAStartOnAGuardAtANegativeCoordinate) {
  for (const double floor : {3.0, -3.0}) {
    const auto height = [floor](const auto&, const auto& x) { return x[0] - floor; };
    Automaton<2, 0, 2> ball;
    ball.mode("flight", FreeFall{})
        .event("impact", "flight", "flight", height, Crossing::falling, Bounce{});
    const HybridSimulation hits =
        run(hybrid_problem(ball), vec({floor, -2.5}), vec({0.0, 0.3}), vec({9.81, 0.8}));
    ASSERT_EQ(hits.status, IntegrationStatus::success) << floor << ": " << hits.message;
    ASSERT_EQ(hits.events.size(), 1u) << floor;
    EXPECT_EQ(hits.events[0].time, 0.0) << floor;
  }
}

// The test for rest compares with gravity in any unit of length.
TEST_P(HybridEdges, RestDetectionIsIndependentOfUnits) {
  for (const double unit : {1e-6, 1.0, 1e6}) {
    IntervalProblem ball = bouncing_ball();
    ball.nominal_state = VectorXd::Constant(2, unit);
    const VectorXd p = vec({9.81 * unit, 0.8}), times = vec({0.0, 0.01});
    const auto status = [&](double speed) {
      return run(ball, vec({0.0, speed * unit}), times, p).status;
    };
    // Relative to gravity, 1e-11 is zero and 1e-2 is not. The threshold is the square root of
    // rounding.
    EXPECT_EQ(status(1e-10), IntegrationStatus::ambiguous_start) << unit;
    EXPECT_EQ(status(0.1), IntegrationStatus::success) << unit;
  }
}

TEST_P(HybridEdges, HandlesAStartBehindAGuard) {
  const VectorXd p = vec({9.81, 0.8});
  // A shooting node just behind the jump of its predecessor: it moves back without a second jump.
  const HybridSimulation near = run(bouncing_ball(), vec({-1e-9, 2.0}), vec({0.0, 0.3}), p);
  ASSERT_EQ(near.status, IntegrationStatus::success) << near.message;
  EXPECT_TRUE(near.events.empty());
  const HybridSimulation sinks = run(bouncing_ball(), vec({-0.1, -1.0}), vec({0.0, 0.3}), p);
  EXPECT_EQ(sinks.status, IntegrationStatus::beyond_guard);
  const HybridSimulation turns = run(bouncing_ball(), vec({-1.0, 0.5}), vec({0.0, 0.3}), p);
  EXPECT_EQ(turns.status, IntegrationStatus::beyond_guard);
  EXPECT_NE(turns.message.find("'flight'"), std::string::npos) << turns.message;
}

// A thermostat that heats up to p_0 + 1/2. Its counter at every switch depends on all arguments.
IntervalProblem thermostat() {
  const auto counts = [](const auto& t, const auto& x, const auto&, const auto& p) {
    return std::decay_t<decltype(x)>{x[0], x[1] * p[0] + sin(3.0 * t) + x[0]};
  };
  Automaton<2, 0, 1> system;
  system
      .mode("heating",
            [](const auto&, const auto& x) {
              return std::decay_t<decltype(x)>{2.0 - 0.1 * x[0], 0.3 * x[1]};
            })
      .mode("cooling",
            [](const auto&, const auto& x) {
              return std::decay_t<decltype(x)>{-0.2 * x[0], 0.0 * x[1]};
            })
      .event(
          "warm", "heating", "cooling",
          [](const auto&, const auto& x, const auto&, const auto& p) { return x[0] - p[0] - 0.5; },
          Crossing::rising, counts)
      .event(
          "cold", "cooling", "heating",
          [](const auto&, const auto& x, const auto&, const auto& p) { return x[0] - p[0] + 0.5; },
          Crossing::falling, counts);
  return hybrid_problem(system);
}

// A set-point that jumps between two intervals: the guard of the active mode is behind the state.
TEST_P(HybridEdges, JumpingGuardTriggersImmediately) {
  const auto integrator = GetParam().choice->make(thermostat());
  auto& hybrid = dynamic_cast<HybridIntegrator&>(*integrator);
  std::vector<HybridEvent> events;
  hybrid.start_in(0);
  hybrid.record(&events);
  const VectorXd w = vec({10.0, 1.0, 6.0, 0.2, 0.4});  // x0, p, t0, h: 3.5 above the guard
  const VectorXd end = end_of(*integrator, w);
  hybrid.record(nullptr);
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].name, "warm");
  EXPECT_EQ(events[0].time, 0.2);
  EXPECT_EQ(events[0].mode_after, "cooling");
  EXPECT_EQ(hybrid.end_mode(), 1);
  EXPECT_NEAR(end[0], 10.0 * std::exp(-0.2 * 0.4), 1e-6);  // one step of order 4
  EXPECT_NEAR(end[1], 6.0 + std::sin(0.6) + 10.0, 1e-9);
  expect_jacobian_matches(*integrator, w, 1e-7);
  // If no mode is given, the state determines it, without an event.
  hybrid.start_in(-1);
  EXPECT_NEAR(end_of(*integrator, w)[1], 1.0, 1e-9);
}

// x = (approaching zero from below, returning below zero). In the given mode, the state reaches the
// first guard at this instant, and the second guard is behind the state.
TEST_P(HybridEdges, ContradictingGuardsLeaveNoMode) {
  Automaton<2> system;
  const auto flow = [](const auto&, const auto& x) {
    return std::decay_t<decltype(x)>{1.0 + 0.0 * x[0], -1.0 + 0.0 * x[1]};
  };
  system.mode("here", flow)
      .mode("there", flow)
      .event(
          "reached", "here", "there", [](const auto&, const auto& x) { return x[0]; },
          Crossing::rising)
      .event(
          "behind", "here", "there", [](const auto&, const auto& x) { return x[1]; },
          Crossing::rising);
  const auto integrator = GetParam().choice->make(hybrid_problem(system));
  auto& hybrid = dynamic_cast<HybridIntegrator&>(*integrator);
  hybrid.start_in(0);
  VectorXd end(2);
  EXPECT_EQ(integrator->value(vec({0.0, 0.1, 0.0, 1.0}).data(), end.data()),
            IntegrationStatus::beyond_guard)
      << end.transpose();
}

// The rate of a logarithm can be finite where its value is NaN; that of a root cannot. On the
// longer intervals, the first evaluation gives a value: positive or negative.
TEST_P(HybridEdges, ReportsAnUndefinedGuard) {
  const auto expect_said = [](const auto& guard) {
    Automaton<1> system;
    system.mode("here", [](const auto&, const auto& x) { return 1.0 + 0.0 * x[0]; })
        .mode("there", [](const auto&, const auto& x) { return 1.0 + 0.0 * x[0]; })
        .event("no number", "here", "there", guard, Crossing::rising);
    const auto integrator = GetParam().choice->make(hybrid_problem(system));
    auto& hybrid = dynamic_cast<HybridIntegrator&>(*integrator);
    hybrid.start_in(0);
    VectorXd end(1);
    for (const double h : {1.0, 22.0, 30.0}) {
      EXPECT_EQ(integrator->value(vec({0.0, 0.0, h}).data(), end.data()),
                IntegrationStatus::not_finite)
          << h;
      EXPECT_NE(integrator->failure().find("event 'no number'"), std::string::npos)
          << integrator->failure();
    }
  };
  expect_said([](const auto&, const auto& x) { return log(x[0] - 5.0); });
  expect_said([](const auto&, const auto& x) { return sqrt(x[0] - 5.0); });
}

// x = (height, speed, number of bounces). The first seven bounces shrink by decreasing factors,
// 0.67, 0.45, ... 0.06. That is not a geometric series, whose limit could be predicted. The eighth
// bounce throws the ball up again.
TEST_P(HybridEdges, FallingShrinkFactorsAreNotAccumulation) {
  Automaton<3> system;
  system
      .mode("flight",
            [](const auto&, const auto& x) {
              return std::decay_t<decltype(x)>{x[1], -10.0 + 0.0 * x[0], 0.0 * x[0]};
            })
      .event(
          "bounce", "flight", "flight", [](const auto&, const auto& x) { return x[0]; },
          Crossing::falling,
          [](const auto&, const auto& x) {
            const auto factor = exp(-0.4 * (x[2] + 1.0)) + exp(40.0 * (x[2] - 6.75));
            return std::decay_t<decltype(x)>{x[0], -factor * x[1], x[2] + 1.0};
          });
  const HybridSimulation sim = run(hybrid_problem(system), vec({0.0, 1.0, 0.0}), vec({0.0, 0.45}));
  ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
  EXPECT_EQ(sim.events.size(), 8u);
  EXPECT_GT(sim.states(0, 1), 0.0);
}

TEST_P(HybridEdges, EventAtTheEndIsTakenOnce) {
  const VectorXd p = vec({9.81, 0.8});
  const double t1 = std::sqrt(2.0 / 9.81);
  const HybridSimulation whole = run(bouncing_ball(), vec({1.0, 0.0}), vec({0.0, 1.0}), p);
  // For one ulp more or less, or an error of a solver's tolerance, there is exactly one impact in
  // total.
  for (const double shift : {0.0, 1e-16, -1e-16, 1e-14, -1e-14, 1e-11, -1e-11, 1e-8, -1e-8}) {
    const HybridSimulation cut =
        run(bouncing_ball(), vec({1.0, 0.0}), vec({0.0, t1 + shift, 1.0}), p);
    ASSERT_EQ(cut.status, IntegrationStatus::success) << cut.message << " " << shift;
    EXPECT_EQ(cut.events.size(), 1u) << shift;
    EXPECT_LE((cut.states.col(2) - whole.states.col(1)).cwiseAbs().maxCoeff(), 1e-11) << shift;
    EXPECT_LE((cut.derivative - whole.derivative).cwiseAbs().maxCoeff(), 1e-8) << shift;
  }
  // At the end, the state is the one after the event.
  const HybridSimulation end = run(bouncing_ball(), vec({1.0, 0.0}), vec({0.0, t1}), p);
  EXPECT_NEAR(end.states(1, 1), 0.8 * 9.81 * t1, 1e-11);
}

TEST_P(HybridEdges, ReportsAResetBehindAGuard) {
  Automaton<1> system;
  system.mode("rise", [](const auto&, const auto& x) { return 1.0 + 0.0 * x[0]; })
      .event(
          "step", "rise", "rise", [](const auto&, const auto& x) { return x[0] - 1.0; },
          Crossing::rising,
          [](const auto&, const auto& x) { return std::decay_t<decltype(x)>{x[0] + 0.5}; });
  const HybridSimulation sim = run(hybrid_problem(system), vec({0.0}), vec({0.0, 2.0}));
  EXPECT_EQ(sim.status, IntegrationStatus::beyond_guard);
  EXPECT_NE(sim.message.find("t = 1 s"), std::string::npos) << sim.message;
  // The ball sticks to the ground: the reset leaves it on the guard, moving into it.
  const HybridSimulation glued =
      run(bouncing_ball(), vec({1.0, 0.0}), vec({0.0, 1.0}), vec({9.81, -0.5}));
  EXPECT_EQ(glued.status, IntegrationStatus::beyond_guard);
  EXPECT_NE(glued.message.find("event 'impact'"), std::string::npos) << glued.message;
}

// x = (position, height over a surface that moves): slides on x_1 = 0.2 sin(2 t) p.
IntervalProblem moving_surface() {
  Automaton<2, 0, 1> system;
  system
      .mode("below",
            [](const auto& t, const auto& x, const auto&, const auto& p) {
              return std::decay_t<decltype(x)>{1.0 + 0.5 * x[1] * p[0], 2.0 + 0.3 * sin(t) - x[0]};
            })
      .mode("above",
            [](const auto& t, const auto& x, const auto&, const auto& p) {
              return std::decay_t<decltype(x)>{-0.5 * p[0] + x[1], -1.5 + 0.2 * t * x[0]};
            })
      .surface("moving", "below", "above",
               [](const auto& t, const auto& x, const auto&, const auto& p) {
                 return x[1] - 0.2 * sin(2.0 * t) * p[0] + 0.1 * x[0] * x[0];
               });
  IntervalProblem problem = hybrid_problem(system);
  problem.running_cost =
      make_function<2, 0, 1>([](const auto& t, const auto& x, const auto&, const auto& p) {
        return x[0] * x[0] + t * x[1] * p[0];
      });
  return problem;
}

TEST(HybridSliding, FollowsAMovingSurfaceWithExactDerivatives) {
  for (const auto& scheme : {cvodes(tight_options), runge_kutta8({.steps = 30})}) {
    const auto integrator = scheme->make(moving_surface());
    auto& hybrid = dynamic_cast<HybridIntegrator&>(*integrator);
    std::vector<HybridEvent> events;
    hybrid.record(&events);
    const VectorXd w = vec({0.1, -0.5, 1.1, 0.2, 0.9});  // x0, p, t0, h
    const VectorXd end = end_of(*integrator, w);
    hybrid.record(nullptr);
    ASSERT_EQ(events.size(), 1u);
    EXPECT_EQ(events[0].kind, HybridEvent::Kind::slides);
    const double t = w[3] + w[4];
    EXPECT_NEAR(end[1], 0.2 * std::sin(2.0 * t) * w[2] - 0.1 * end[0] * end[0], 1e-14);
    // Differences at the integrator's tolerance of 1e-12.
    expect_jacobian_matches(*integrator, w, 1e-8);
  }
}

TEST(HybridSliding, LeavesWithExactDerivatives) {
  // The field above turns: the state leaves where 0.3 (t - 1) - 0.2 p x_0 = 0.
  Automaton<2, 0, 1> system;
  system
      .mode("below",
            [](const auto&, const auto& x) {
              return std::decay_t<decltype(x)>{1.0 + 0.2 * x[0], 1.0 + 0.1 * x[0]};
            })
      .mode("above",
            [](const auto& t, const auto& x, const auto&, const auto& p) {
              return std::decay_t<decltype(x)>{0.5 * p[0] + x[1],
                                               0.6 * (t - 1.0) - 0.2 * p[0] * x[0]};
            })
      .surface("floor", "below", "above",
               [](const auto&, const auto& x) { return x[1] + 0.1 * x[0]; });
  for (const auto& scheme : {cvodes(tight_options), runge_kutta8({.steps = 60})}) {
    const auto integrator = scheme->make(hybrid_problem(system));
    auto& hybrid = dynamic_cast<HybridIntegrator&>(*integrator);
    std::vector<HybridEvent> events;
    hybrid.record(&events);
    const VectorXd w = vec({0.1, -0.3, 0.4, 0.0, 3.0});
    end_of(*integrator, w);
    hybrid.record(nullptr);
    ASSERT_EQ(events.size(), 2u);
    EXPECT_EQ(events[0].kind, HybridEvent::Kind::slides);
    EXPECT_EQ(events[1].kind, HybridEvent::Kind::leaves);
    EXPECT_EQ(events[1].mode_after, "above");
    expect_jacobian_matches(*integrator, w, 1e-8);
  }
}

// An event of both fields ends sliding. The next mode has other events, none of them near.
TEST(HybridSliding, EndsWithAnEventOfBothFields) {
  using X = Vec<double, 2>;
  Automaton<2> system;
  const auto distance = [](const auto&, const auto& x) { return x[0] - 1.0; };
  system
      .mode("below",
            [](const auto&, const auto& x) {
              return std::decay_t<decltype(x)>{1.0 + 0.0 * x[0], 1.0 + 0.0 * x[0]};
            })
      .mode("above",
            [](const auto&, const auto& x) {
              return std::decay_t<decltype(x)>{1.0 + 0.0 * x[0], -1.0 + 0.0 * x[0]};
            })
      .mode("beyond",
            [](const auto&, const auto& x) {
              return std::decay_t<decltype(x)>{0.0 * x[0], 0.5 + 0.0 * x[0]};
            })
      .surface("floor", "below", "above", [](const auto&, const auto& x) { return x[1]; })
      .event("end", "below", "beyond", distance, Crossing::rising)
      .event("end", "above", "beyond", distance, Crossing::rising)
      .event(
          "far", "beyond", "below", [](const auto&, const auto& x) { return x[0] - 9.0; },
          Crossing::rising)
      .event(
          "high", "beyond", "above", [](const auto&, const auto& x) { return x[1] - 9.0; },
          Crossing::rising);
  for (const auto& scheme : {cvodes(tight_options), runge_kutta8({.steps = 4})}) {
    const HybridSimulation sim =
        simulate_hybrid(scheme, hybrid_problem(system), X(0.0, -0.5), vec({0.0, 2.0}),
                        MatrixXd(0, 1), VectorXd(), "below");
    ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
    ASSERT_EQ(sim.events.size(), 2u);
    EXPECT_EQ(sim.events[0].kind, HybridEvent::Kind::slides);
    EXPECT_NEAR(sim.events[0].time, 0.5, 1e-11);
    EXPECT_EQ(sim.events[1].name, "end");
    EXPECT_NEAR(sim.events[1].time, 1.0, 1e-11);
    EXPECT_EQ(sim.end_mode, "beyond");
    EXPECT_NEAR(sim.states(1, 1), 0.5, 1e-11);
  }
}

TEST(HybridSliding, RejectsSlidingOnAChangingInput) {
  Automaton<1, 1> system;
  system.mode("below", [](const auto&, const auto& x) { return 1.0 + 0.0 * x[0]; })
      .mode("above", [](const auto&, const auto& x) { return -1.0 + 0.0 * x[0]; })
      .surface("input", "below", "above",
               [](const auto&, const auto& x, const auto& u) { return x[0] - u[0]; });
  const auto scheme = runge_kutta8({.steps = 5});
  const auto constant = scheme->make(hybrid_problem(system));
  VectorXd end(1);
  const VectorXd w = vec({0.0, 0.3, 0.0, 1.0});
  EXPECT_EQ(constant->value(w.data(), end.data()), IntegrationStatus::success);
  EXPECT_NEAR(end[0], 0.3, 1e-14);
  const auto linear = scheme->make(hybrid_problem(system, InputShape::linear));
  const VectorXd w_linear = vec({0.0, 0.3, 0.3, 0.0, 1.0});
  EXPECT_EQ(linear->value(w_linear.data(), end.data()), IntegrationStatus::sliding_input);
}

// z = 1 + t, repeated many times. x' = z up to x = 3/2, at t = 1, and then 2 z. The first mode has
// a separate cost.
TEST(HybridModes, ModeWithoutCostUsesTheIntervalCost) {
  constexpr int nz = 16;
  const auto faster = [](double factor) {
    return [factor](const auto&, const auto&, const auto& z) { return factor * z[nz - 1]; };
  };
  const auto equations = [](const auto& t, const auto&, const auto& z) {
    std::decay_t<decltype(z)> g = z;
    for (int i = 0; i < nz; ++i) g[i] -= 1.0 + t;
    return g;
  };
  Automaton<1, 0, 0, nz> system(equations, Vec<double, nz>::Ones());
  system.mode("slow", faster(1.0))
      .mode("fast", faster(2.0))
      .event(
          "half-way", "slow", "fast", [](const auto&, const auto& x) { return x[0] - 1.5; },
          Crossing::rising);
  IntervalProblem problem;
  problem.arguments = {1, 0, 0};
  problem.switching = system.system();
  problem.dynamics = problem.switching.modes.front().dynamics;
  const auto cost = [](double rate) {
    return make_function<1, 0, 0>([rate](const auto&, const auto& x) { return rate + 0.0 * x[0]; });
  };
  problem.running_cost = cost(1.0);
  problem.switching.modes[0].running_cost = cost(3.0);
  for (const IntegratorChoice& scheme :
       {idas({.tolerance = 1e-10}), cvodes(tight_options), runge_kutta4({.steps = 3}),
        gauss_legendre({.stages = 2, .steps = 2}), radau_iia({.stages = 3})}) {
    const auto integrator = scheme->make(problem);
    VectorXd end(2);
    ASSERT_EQ(integrator->value(vec({0.0, 0.0, 2.0}).data(), end.data()),
              IntegrationStatus::success)
        << scheme->name();
    // A hundred times the tolerance of a step, relative to the size of x.
    EXPECT_NEAR(end[0], 6.5, 6.5e-8) << scheme->name();
    EXPECT_NEAR(end[1], 3.0 + 1.0, 6.5e-8) << scheme->name();
  }
}

// A NaN entry of a Jacobian affects only its mode and its call. The integrator does not keep it.
TEST(HybridModes, DiscardsAnInvalidJacobian) {
  Automaton<3> system;
  const auto level = [](const auto&, const auto& x) { return x[0] - 1.0; };
  system
      .mode("full",
            [](const auto&, const auto& x) {
              using std::sin;  // finite value and infinite slope at 0
              return std::decay_t<decltype(x)>{0.1 * x[1] + x[2], x[2] - x[1],
                                               1e200 * sin(1e200 * x[2])};
            })
      .mode("empty",
            [](const auto&, const auto& x) {
              return std::decay_t<decltype(x)>{-x[0], 0.0 * x[1], 0.0 * x[2]};
            })
      .event("up", "full", "empty", level, Crossing::rising)
      .event("down", "empty", "full", level, Crossing::falling);
  for (const CvodesOptions::Method method :
       {CvodesOptions::Method::Bdf, CvodesOptions::Method::Adams}) {
    const IntegratorChoice scheme = cvodes({.method = method, .tolerance = 1e-9});
    const auto used = scheme->make(hybrid_problem(system)),
               fresh = scheme->make(hybrid_problem(system));
    VectorXd end(3), expected(3);
    MatrixXd derivative(3, used->arguments().size()), known = derivative;
    EXPECT_NE(used->jacobian(vec({0.0, 0.0, 0.0, 0.0, 0.1}).data(), end.data(), derivative),
              IntegrationStatus::success);
    const VectorXd w = vec({5.0, 0.0, 1.0, 0.0, 0.1});
    ASSERT_EQ(fresh->jacobian(w.data(), expected.data(), known), IntegrationStatus::success);
    ASSERT_EQ(used->jacobian(w.data(), end.data(), derivative), IntegrationStatus::success)
        << used->failure();
    EXPECT_EQ(end, expected);
    EXPECT_EQ(derivative, known);
  }
}

TEST(HybridModes, HandleAHysteresisChain) {
  // A thermostat: x' = -x (off) or 2 - x (on). Between 0.5 and 1.5, both modes are valid.
  Automaton<1> system;
  system.mode("off", [](const auto&, const auto& x) { return -1.0 * x[0]; })
      .mode("on", [](const auto&, const auto& x) { return 2.0 - x[0]; })
      .event(
          "cold", "off", "on", [](const auto&, const auto& x) { return x[0] - 0.5; },
          Crossing::falling)
      .event(
          "warm", "on", "off", [](const auto&, const auto& x) { return x[0] - 1.5; },
          Crossing::rising);
  const double leg = std::log(3.0);  // s, each
  const VectorXd times = vec({0.0, 0.3, 1.0, 2.0, 5.0});
  const HybridSimulation sim = simulate_hybrid(runge_kutta8({.steps = 40}), hybrid_problem(system),
                                               vec({0.5}), times, MatrixXd(0, 4), VectorXd(), "on");
  ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
  ASSERT_EQ(sim.events.size(), 4u);
  for (int i = 0; i < 4; ++i) {
    EXPECT_NEAR(sim.events[i].time, (i + 1) * leg, 1e-11);
    EXPECT_EQ(sim.events[i].name, i % 2 == 0 ? "warm" : "cold");
  }
  EXPECT_EQ(sim.end_mode, "on");
  EXPECT_THROW(simulate_hybrid(runge_kutta8(), hybrid_problem(system), vec({0.5}), times,
                               MatrixXd(0, 4), VectorXd(), "warm"),
               DefinitionError);
}

// --- second derivatives ---------------------------------------------------------------------

class HybridSecondOrder : public ::testing::TestWithParam<HybridScheme> {};
INSTANTIATE_TEST_SUITE_P(Schemes, HybridSecondOrder,
                         ::testing::Values(HybridScheme{"rk4", runge_kutta4({.steps = 3})},
                                           HybridScheme{"gauss2",
                                                        gauss_legendre({.stages = 1, .steps = 4})},
                                           HybridScheme{"radau5", radau_iia({.stages = 3})}),
                         [](const auto& param) { return param.param.name; });

// Differences of derivatives that are exact to 1e-13. The steps move events by far less than the
// distance between them.
constexpr double second_difference = 2e-8;

TEST_P(HybridSecondOrder, MatchesDifferencesThroughJumpsWithARunningCost) {
  IntervalProblem problem = bouncing_ball();
  problem.running_cost =
      make_function<2, 0, 2>([](const auto& t, const auto& x, const auto&, const auto& p) {
        return x[0] * x[0] + t * x[1] * p[1];
      });
  const auto integrator = GetParam().choice->make(problem);
  const VectorXd w = vec({1.0, 0.2, 9.81, 0.8, 0.1, 1.93});  // three impacts
  std::vector<HybridEvent> events;
  dynamic_cast<HybridIntegrator&>(*integrator).record(&events);
  end_of(*integrator, w);
  dynamic_cast<HybridIntegrator&>(*integrator).record(nullptr);
  ASSERT_EQ(events.size(), 3u);
  expect_jacobian_matches(*integrator, w, 100 * second_difference);
  expect_hessian_matches(*integrator, w, vec({0.7, -1.3, 0.4}), 100 * second_difference);
  // Gauss-Newton: the running cost in first-order sensitivities, without second-order terms.
  const MatrixXd exact = hessian_of(*integrator, w, vec({0.7, -1.3, 0.4}));
  const MatrixXd approximate =
      hessian_of(*integrator, w, vec({0.7, -1.3, 0.4}), Curvature::gauss_newton);
  EXPECT_GT((exact - approximate).norm(), 1.0);
  EXPECT_GT(approximate.norm(), 0.1);
}

TEST_P(HybridSecondOrder, MatchesDifferencesWithAStoredMode) {
  // The thermostat, its heat and a drift of both thresholds in the parameter. State 1 stores the
  // mode.
  Automaton<2, 0, 1> system;
  const auto threshold = [](double level) {
    return [level](const auto& t, const auto& x, const auto&, const auto& p) {
      return x[0] - level - 0.05 * t * t * p[0];
    };
  };
  system
      .mode("off",
            [](const auto&, const auto& x, const auto&, const auto& p) {
              return std::decay_t<decltype(x)>{-1.0 * x[0] * p[0], 0.0 * x[1]};
            })
      .mode("on",
            [](const auto& t, const auto& x, const auto&, const auto& p) {
              return std::decay_t<decltype(x)>{2.0 * p[0] - x[0] + 0.1 * t, 0.0 * x[1]};
            })
      .event("cold", "off", "on", threshold(0.5), Crossing::falling)
      .event("warm", "on", "off", threshold(1.5), Crossing::rising)
      .store_mode_in(1);
  const auto integrator = GetParam().choice->make(hybrid_problem(system));
  // Starts in the middle and behind the threshold of "cold", whose event then happens immediately.
  for (const double start : {0.9, 0.3}) {
    const VectorXd w = vec({start, 0.0, 1.1, 0.2, 2.6});  // x0, p, t0, h
    EXPECT_EQ(end_of(*integrator, w)[1], 1.0);            // on, off and on again, or immediately on
    expect_hessian_matches(*integrator, w, vec({0.7, -1.3}), second_difference);
  }
}

TEST_P(HybridSecondOrder, IsContinuousAtLengthZeroAndUnavailableWhileSliding) {
  const auto integrator = GetParam().choice->make(bouncing_ball());
  VectorXd w = vec({1.0, 0.2, 9.81, 0.8, 0.1, 0.0});
  const VectorXd weights = vec({0.7, -1.3});
  const MatrixXd at_zero = hessian_of(*integrator, w, weights);
  w[5] = 1e-6;
  EXPECT_LE((hessian_of(*integrator, w, weights) - at_zero).norm(), 1e-5);
  EXPECT_GT(at_zero.norm(), 0.1);
  EXPECT_FALSE(GetParam().choice->make(moving_surface())->has_hessian());
}

// Event 'half': the state crosses 0.5 upwards at a rate of 1 / s, without a jump. The formula
// throws on demand.
bool throws = false;
IntervalProblem ramp_with_an_event() {
  const auto ramp = [](const auto&, const auto& x) {
    if (throws) throw std::runtime_error("the table ends here");
    return std::decay_t<decltype(x)>{1.0 + 0.0 * x[0]};
  };
  Automaton<1> system;
  system.mode("first", ramp)
      .mode("second", ramp)
      .event(
          "half", "first", "second", [](const auto&, const auto& x) { return x[0] - 0.5; },
          Crossing::rising);
  return hybrid_problem(system);
}

TEST(HybridModes, LeavesMissingSecondDerivativesUnset) {
  const VectorXd w = vec({0.0, 0.0, 1.0}), weight = vec({1.0});
  VectorXd end(1);
  MatrixXd first(1, 3), second(3, 3);
  const auto expect = [&](Integrator& integrator) {
    ASSERT_FALSE(integrator.has_hessian());
    EXPECT_EQ(integrator.hessian(w.data(), weight.data(), second, Curvature::exact),
              IntegrationStatus::library_failure);
    EXPECT_EQ(integrator.derivatives(w.data(), weight.data(), end.data(), first, second,
                                     Curvature::exact),
              IntegrationStatus::library_failure);
    EXPECT_EQ(integrator.jacobian(w.data(), end.data(), first), IntegrationStatus::success);
  };
  expect(*cvodes()->make(ramp_with_an_event()));
  Automaton<1> surface;
  surface.mode("below", [](const auto&, const auto& x) { return 1.0 + 0.0 * x[0]; })
      .mode("above", [](const auto&, const auto& x) { return -1.0 + 0.0 * x[0]; })
      .surface("level", "below", "above", [](const auto&, const auto& x) { return x[0] - 0.5; });
  expect(*runge_kutta4()->make(hybrid_problem(surface)));
}

// Second derivatives are recorded on a tape. A formula that throws must not leave it recording.
TEST(HybridModes, ThrowingFormulaLeavesNoState) {
  const auto integrator = runge_kutta4({.steps = 4})->make(ramp_with_an_event());
  auto& hybrid = dynamic_cast<EventIntegrator&>(*integrator);
  const VectorXd w = vec({0.0, 0.0, 1.0}), nowhere = vec({0.0, 0.0, 0.0}), weight = vec({1.0});
  VectorXd end(1);
  MatrixXd first(1, 3), second(3, 3);
  std::vector<HybridEvent> events;
  hybrid.record(&events);
  throws = true;
  EXPECT_THROW(
      integrator->derivatives(w.data(), weight.data(), end.data(), first, second, Curvature::exact),
      std::runtime_error);
  EXPECT_THROW(integrator->value(nowhere.data(), end.data()), std::runtime_error);
  throws = false;
  integrator->value(w.data(), end.data());
  EXPECT_EQ(events.size(), 1u);
  hybrid.record(nullptr);
  const testing::AllocationCount allocations;
  for (int i = 0; i < 100; ++i) integrator->value(w.data(), end.data());
  EXPECT_EQ(allocations.made(), 0);
}

TEST(HybridModes, HandlesZeroAndNegativeLength) {
  const auto integrator = runge_kutta8()->make(bouncing_ball());
  VectorXd w = vec({1.0, -2.0, 9.81, 0.8, 0.0, 0.0});
  EXPECT_EQ(end_of(*integrator, w), w.head(2));
  const MatrixXd derivative = jacobian_of(*integrator, w);
  EXPECT_EQ(derivative(0, 0), 1.0);
  EXPECT_EQ(derivative(0, 5), -2.0);
  EXPECT_EQ(derivative(1, 5), -9.81);
  VectorXd end(2);
  w[5] = -0.1;
  EXPECT_EQ(integrator->value(w.data(), end.data()), IntegrationStatus::backward);
}

}  // namespace
}  // namespace saltus
