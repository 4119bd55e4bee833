// Events against closed forms: times, states and derivatives, by every scheme that handles events.
#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/simulate.hpp"
#include "tests/integrators/hybrid_problems.hpp"
#include "tests/integrators/support.hpp"

namespace saltus {
namespace {

using namespace test;

// The integrators aim at 1e-12. The error of a whole flight is up to a hundred times that of a
// step.
const CvodesOptions tighter_options{
    .method = CvodesOptions::Method::Adams, .tolerance = 2e-14, .absolute_tolerance = 1e-16};

class HybridSchemes : public HybridSchemeTest {};
INSTANTIATE_TEST_SUITE_P(
    Schemes, HybridSchemes,
    testing::Values(HybridScheme{"adams", cvodes(tighter_options)},
                    HybridScheme{"bdf", cvodes({.tolerance = 2e-14, .absolute_tolerance = 1e-16})},
                    HybridScheme{"rk8", runge_kutta8({.steps = 150})},
                    HybridScheme{"gauss8", gauss_legendre({.stages = 4, .steps = 60})},
                    HybridScheme{"radau7", radau_iia({.stages = 4, .steps = 90})}),
    [](const auto& param) { return param.param.name; });

const VectorXd ball_parameters = vec({9.81, 0.8});

TEST_P(HybridSchemes, SimulateABouncingBall) {  // D07
  const HybridSimulation sim =
      run(bouncing_ball(), vec({1.0, 0.0}), vec({0.0, 1.0, 2.0, 3.0}), ball_parameters);
  ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
  const std::vector<double> impacts{0.451523640985731, 1.1739614665629,  1.75191172702464,
                                    2.21427193539402,  2.58416010208954, 2.88007063544594};
  ASSERT_EQ(sim.events.size(), impacts.size());
  for (std::size_t i = 0; i < impacts.size(); ++i) {
    EXPECT_NEAR(sim.events[i].time, impacts[i], 1e-12) << i;
    EXPECT_EQ(sim.events[i].name, "impact");
    EXPECT_EQ(sim.events[i].kind, HybridEvent::Kind::jumps);
    EXPECT_NEAR(sim.events[i].after[1], -0.8 * sim.events[i].before[1], 1e-14);
  }
  // d t1 / d (h0, v0, g, e): t1 = (v0 + sqrt(v0^2 + 2 g h0)) / g.
  const double root = std::sqrt(2.0 * 9.81);
  const VectorXd expected = vec({1.0 / root, 1.0 / 9.81, -0.5 * root / (9.81 * 9.81), 0.0});
  EXPECT_LE((sim.events[0].time_derivative - expected).cwiseAbs().maxCoeff(), 1e-12);
  Mat<double, 2, 3> states;
  states << 0.468004452526036, 0.260741728327057, 0.0687074609657657,  //
      -1.83699554747396, -0.165869135836471, -0.0153541333847448;
  EXPECT_LE((sim.states.rightCols(3) - states).cwiseAbs().maxCoeff(), 1e-11);
}

TEST_P(HybridSchemes, MatchTheSensitivitiesOfABouncingBall) {  // D07, at t = 1
  Mat<double, 2, 4> expected;                                  // h0, v0, g, e
  expected << 1.38650222626302, 0.187257446225684, -0.0936287231128422, 2.42944691807002,  //
      3.98650222626302, 1.0, -0.593628723112842, 4.42944691807002;
  const HybridSimulation sim =
      run(bouncing_ball(), vec({1.0, 0.0}), vec({0.0, 1.0}), ball_parameters);
  ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
  EXPECT_LE((sim.derivative - expected).cwiseAbs().maxCoeff(), 1e-9) << sim.derivative;
  // The same with shooting intervals, one of which ends where the ball touches the ground.
  const HybridSimulation cut =
      run(bouncing_ball(), vec({1.0, 0.0}), vec({0.0, 0.3, std::sqrt(2.0 / 9.81), 0.6, 1.0}),
          ball_parameters);
  ASSERT_EQ(cut.status, IntegrationStatus::success) << cut.message;
  EXPECT_EQ(cut.events.size(), 1u);
  EXPECT_LE((cut.derivative - expected).cwiseAbs().maxCoeff(), 1e-9) << cut.derivative;
}

TEST_P(HybridSchemes, MatchTheSaltationMatrixOfTheBall) {  // D09: just after the impact
  const double t1 = std::sqrt(2.0 / 9.81), v = -9.81 * t1;
  const double before = 1e-3, after = 1e-3;  // s; free fall on both sides is linear in x0
  const auto integrator = GetParam().choice->make(bouncing_ball());
  const VectorXd w = vec({1.0 - 0.5 * 9.81 * (t1 - before) * (t1 - before), -9.81 * (t1 - before),
                          9.81, 0.8, t1 - before, before + after});
  const MatrixXd jacobian = jacobian_of(*integrator, w);
  Mat<double, 2, 2> flow_before, flow_after, expected;
  flow_before << 1.0, before, 0.0, 1.0;
  flow_after << 1.0, after, 0.0, 1.0;
  expected << -0.8, 0.0, -1.8 * 9.81 / v, -0.8;
  EXPECT_NEAR(expected(1, 0), 3.98650222626302, 1e-13);
  const MatrixXd saltation = flow_after.inverse() * jacobian.leftCols(2) * flow_before.inverse();
  EXPECT_LE((saltation - expected).cwiseAbs().maxCoeff(), 1e-10) << saltation;
}

TEST_P(HybridSchemes, SimulateTheStanceOfASpringLeg) {  // D11
  const SpringLeg leg;
  const HybridSimulation sim = run(leg.problem(), vec({0.0, -1.0}), vec({0.0, 0.3}));
  ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
  ASSERT_EQ(sim.events.size(), 1u);
  EXPECT_EQ(sim.events[0].mode_before, "stance");
  EXPECT_EQ(sim.events[0].mode_after, "flight");
  EXPECT_NEAR(sim.events[0].time, 0.268933880738875, 1e-12);
  EXPECT_NEAR(sim.events[0].after[1], 1.0, 1e-12);
  // From a flight phase: touchdown, then lift-off.
  const double fall = 0.05;  // s
  const VectorXd x0 = vec({fall * (1.0 - 0.5 * 9.81 * fall), -1.0 + 9.81 * fall});
  const HybridSimulation both = run(leg.problem(), x0, vec({0.0, 0.4}));
  ASSERT_EQ(both.status, IntegrationStatus::success) << both.message;
  ASSERT_EQ(both.events.size(), 2u);
  EXPECT_NEAR(both.events[0].time, fall, 1e-12);
  EXPECT_NEAR(both.events[0].before[1], -1.0, 1e-12);
  EXPECT_NEAR(both.events[1].time, fall + 0.268933880738875, 1e-12);
  EXPECT_NEAR(both.events[1].after[1], 1.0, 1e-12);
  // The largest compression, where the speed is zero.
  const double lowest = 0.5 * 0.268933880738875;
  const HybridSimulation down = run(leg.problem(), vec({0.0, -1.0}), vec({0.0, lowest}));
  EXPECT_NEAR(down.states(1, 1), 0.0, 1e-11);
  EXPECT_NEAR(down.states(0, 1), -0.113669682251102, 1e-12);
}

TEST_P(HybridSchemes, SimulateASwitchOfSpeed) {  // A17: x' = 3 below, 1 above
  const IntervalProblem problem = scalar_filippov(Ramp{3.0, 0.0}, Ramp{1.0, 0.0});
  const HybridSimulation sim = run(problem, vec({-1.0}), vec({0.0, 2.0}));
  ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
  ASSERT_EQ(sim.events.size(), 1u);
  EXPECT_EQ(sim.events[0].kind, HybridEvent::Kind::crosses);
  EXPECT_NEAR(sim.events[0].time, 1.0 / 3.0, 1e-13);
  EXPECT_NEAR(sim.end_mode == "above" ? sim.states(0, 1) : -1.0, 5.0 / 3.0, 1e-12);
  EXPECT_NEAR(sim.derivative(0, 0), 1.0 / 3.0, 1e-12);
}

TEST_P(HybridSchemes, SimulateAnOscillatorWithAnExactSwitch) {  // A18
  const double T = std::numbers::pi / 2;
  const HybridSimulation sim = run(oscillator(), vec({std::exp(-1.0), 0.0}), vec({0.0, T}));
  ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
  ASSERT_EQ(sim.events.size(), 1u);
  EXPECT_NEAR(sim.events[0].time, 1.0, 1e-10);
  EXPECT_NEAR(sim.states(0, 1), -1.59746037745070, 1e-10);
  EXPECT_NEAR(sim.states(1, 1), 0.76149362060601, 1e-10);
}

TEST_P(HybridSchemes, CrossAFilippovSurface) {  // A19
  const HybridSimulation sim =
      run(scalar_filippov(Ramp{2.0, 0.0}, Ramp{0.2, 0.0}), vec({-1.0}), vec({0.0, 1.5}));
  ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
  EXPECT_NEAR(sim.events.at(0).time, 0.5, 1e-12);
  EXPECT_NEAR(sim.states(0, 1), 0.2, 1e-12);
  EXPECT_NEAR(sim.derivative(0, 0), 0.1, 1e-12);
}

TEST_P(HybridSchemes, EnterFilippovSliding) {  // A19
  const HybridSimulation sim =
      run(scalar_filippov(Ramp{1.0, 0.0}, Ramp{-1.0, 0.0}), vec({-0.5}), vec({0.0, 1.5}));
  ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
  ASSERT_EQ(sim.events.size(), 1u);
  EXPECT_EQ(sim.events[0].kind, HybridEvent::Kind::slides);
  EXPECT_NEAR(sim.events[0].time, 0.5, 1e-12);
  EXPECT_NEAR(sim.states(0, 1), 0.0, 1e-14);
  EXPECT_NEAR(sim.derivative(0, 0), 0.0, 1e-12);
  EXPECT_EQ(sim.end_mode, "sliding on 'zero'");
}

TEST_P(HybridSchemes, LeaveFilippovSliding) {  // A19
  const IntervalProblem problem = scalar_filippov(Ramp{1.0, 1.0}, Ramp{-1.0, 1.0});
  for (const VectorXd& times : {vec({0.0, 1.5}), vec({0.0, 0.4, 1.0, 1.2, 1.5})}) {
    const HybridSimulation sim = run(problem, vec({0.0}), times);
    ASSERT_EQ(sim.status, IntegrationStatus::success) << sim.message;
    ASSERT_EQ(sim.events.size(), 2u);
    EXPECT_EQ(sim.events[0].kind, HybridEvent::Kind::slides);
    EXPECT_EQ(sim.events[0].time, 0.0);
    EXPECT_EQ(sim.events[1].kind, HybridEvent::Kind::leaves);
    EXPECT_NEAR(sim.events[1].time, 1.0, 1e-12);
    EXPECT_EQ(sim.end_mode, "above");
    EXPECT_NEAR(sim.states(0, sim.intervals), 0.125, 1e-12);
    EXPECT_NEAR(sim.derivative(0, 0), 0.0, 1e-12);
  }
}

TEST_P(HybridSchemes, ReportASpontaneousFilippovSwitch) {  // A19
  const HybridSimulation sim =
      run(scalar_filippov(Ramp{-1.0, 0.0}, Ramp{1.0, 0.0}), vec({0.0}), vec({0.0, 1.5}));
  EXPECT_EQ(sim.status, IntegrationStatus::non_unique);
  EXPECT_NE(sim.message.find("not unique"), std::string::npos) << sim.message;
  EXPECT_NE(sim.message.find("t = 0 s"), std::string::npos) << sim.message;
  EXPECT_NE(sim.message.find("'zero'"), std::string::npos) << sim.message;
}

TEST_P(HybridSchemes, AccumulationIsReported) {  // D07 beyond 4.0637 s
  const HybridSimulation sim =
      run(bouncing_ball(), vec({1.0, 0.0}), vec({0.0, 5.0}), ball_parameters);
  EXPECT_EQ(sim.status, IntegrationStatus::accumulation);
  EXPECT_NE(sim.message.find("t = 4.0637"), std::string::npos) << sim.message;
  EXPECT_NE(sim.message.find("'flight', event 'impact'"), std::string::npos) << sim.message;
}

}  // namespace
}  // namespace saltus
