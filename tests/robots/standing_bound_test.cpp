// The closed form of the pendulum with flywheel against a linear program that uses only the
// discretised dynamics, and against figures computed elsewhere.
#include "tests/support/standing_bound.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "tests/support/linear_program.hpp"

namespace saltus::robots {
namespace {

// iCub on its left foot, CoM above the origin of the sole frame, pushed towards -y, where the real
// sole ends at y = -0.031 m. The hips and the torso turn the body with at most 40 Nm.
const StandingPush icub{.mass = 33.0617,
                        .height = 0.534,
                        .distance_to_edge = 0.031,
                        .duration = 0.1,
                        .torque = 40.0,
                        .settle_time = 2.0};

// Least peak |H| by linear programming: unknown centre of pressure and H' constant on each of
// `intervals` steps, the capture point integrated exactly, the foot reaching 0.041 m backwards.
double by_linear_program(double impulse, const StandingPush& push, int intervals) {
  const double omega = pendulum_frequency(push.height);
  const double dt = push.settle_time / intervals;
  const double grow = std::exp(omega * dt);
  const double per_newton = (grow - 1.0) / (push.mass * omega * omega);
  const Bounds foot = between(-0.041, push.distance_to_edge);

  testing::LinearProgram lp;
  const int peak = lp.variable(at_least(0.0), 1.0);
  int xi = lp.variable(exactly(0.0));  // the CoM at rest
  int h = lp.variable(exactly(0.0));
  for (int k = 0; k < intervals; ++k) {
    const bool last = k + 1 == intervals;
    const int p = lp.variable(foot);
    const int torque = lp.variable(between(-push.torque, push.torque));
    const int next_xi = lp.variable(last ? foot : unbounded());
    const int next_h = lp.variable(last ? exactly(0.0) : unbounded());
    // The push covers whole intervals (the test chooses dt accordingly).
    const double force = (k + 0.5) * dt < push.duration ? impulse / push.duration : 0.0;
    lp.row({{next_xi, 1.0}, {xi, -grow}, {p, grow - 1.0}, {torque, per_newton / push.height}},
           exactly(per_newton * force));
    lp.row({{next_h, 1.0}, {h, -1.0}, {torque, -dt}}, exactly(0.0));
    lp.row({{next_h, 1.0}, {peak, -1.0}}, at_most(0.0));
    lp.row({{next_h, 1.0}, {peak, 1.0}}, at_least(0.0));
    xi = next_xi;
    h = next_h;
  }
  const testing::LinearProgramResult result = testing::solve(lp);
  EXPECT_TRUE(result.optimal) << impulse << " N s in " << intervals << " intervals";
  return result.objective;
}

TEST(StandingBound, ReproducesThePublishedFigures) {
  // Printed with two or three digits, computed with intervals of 10 ms.
  EXPECT_NEAR(by_linear_program(6.0, icub, 200), 0.27, 0.006);
  EXPECT_NEAR(by_linear_program(7.5, icub, 200), 1.0, 0.06);
  EXPECT_NEAR(by_linear_program(8.0, icub, 200), 1.2, 0.02);
  EXPECT_NEAR(by_linear_program(10.0, icub, 200), 2.25, 0.02);
}

TEST(StandingBound, IsTheLimitOfTheLinearProgram) {
  for (const double impulse : {6.0, 7.5, 8.0, 10.0}) {
    const double exact = least_peak_angular_momentum(impulse, icub);
    const double coarse = by_linear_program(impulse, icub, 100);
    const double fine = by_linear_program(impulse, icub, 400);
    // Coarse controls are a subset of fine ones, and both are a subset of continuous ones.
    EXPECT_GE(coarse, fine - 1e-7) << impulse << " N s";
    EXPECT_GE(fine, exact - 1e-7) << impulse << " N s";
    EXPECT_LT(fine, 1.005 * exact) << impulse << " N s";
    RecordProperty(std::to_string(impulse), std::to_string(exact));
  }
}

TEST(StandingBound, IsExactWithSwitchesOnTheGrid) {
  // With the peak chosen so that H is full after exactly 3 intervals of 10 ms, the best continuous
  // H is one of the discretised ones.
  const double peak = icub.torque * 0.03;
  const double impulse = largest_impulse_standing(peak, icub);
  EXPECT_NEAR(least_peak_angular_momentum(impulse, icub), peak, 1e-12);
  EXPECT_NEAR(by_linear_program(impulse, icub, 200), peak, 1e-6);  // the solver's accuracy
}

TEST(StandingBound, OneNmsEqualsAboutTwoNewtonSeconds) {
  EXPECT_NEAR(largest_impulse_standing(0.0, icub), 5.4, 0.05);
  EXPECT_NEAR(largest_impulse_standing(1.0, icub), 7.5, 0.1);
  EXPECT_GT(least_peak_angular_momentum(8.0, icub), 1.0);
}

TEST(StandingBound, EqualsThePendulumWithoutFlywheel) {
  const double none = largest_impulse_standing(0.0, icub);
  EXPECT_EQ(least_peak_angular_momentum(0.999 * none, icub), 0.0);
  EXPECT_GT(least_peak_angular_momentum(1.001 * none, icub), 0.0);
  // A short push is an instantaneous one: J = m omega d0.
  StandingPush brief = icub;
  brief.duration = 1e-6;
  EXPECT_NEAR(largest_impulse_standing(0.0, brief), 33.0617 * pendulum_frequency(0.534) * 0.031,
              1e-4);
}

TEST(StandingBound, ImpulseAndPeakAreInverse) {
  for (const double torque : {10.0, 40.0, infinity}) {
    StandingPush push = icub;
    push.torque = torque;
    for (const double peak : {1e-4, 0.1, 0.5, 2.0, 5.0})
      EXPECT_NEAR(least_peak_angular_momentum(largest_impulse_standing(peak, push), push), peak,
                  1e-9 * peak + 1e-13)
          << "torque " << torque;
  }
}

TEST(StandingBound, ReportsWhenNoFlywheelSuffices) {
  StandingPush weak = icub;
  weak.torque = 5.0;
  EXPECT_EQ(least_peak_angular_momentum(50.0, weak), infinity);
}

TEST(StandingBound, BoundsAPushWithAStep) {
  // Published: 7.3 and 9.5 N s for the foot at -0.14 and -0.30 m, landing 0.6 s after the push
  // begins. The right sole ends 0.041 m outside its origin, the left one 0.031 m inside; the
  // formula then gives 7.40 and 9.53.
  EXPECT_NEAR(largest_impulse_with_step(0.14 + 0.041 - 0.031, 0.6, icub), 7.3, 0.11);
  EXPECT_NEAR(largest_impulse_with_step(0.30 + 0.041 - 0.031, 0.6, icub), 9.5, 0.05);
  // In the form of the text: m omega^2 T (d0 e^(omega T) + D e^(-omega (ts - T))) / (e^(omega
  // T)-1).
  const double omega = pendulum_frequency(icub.height);
  const double growth = std::exp(omega * 0.1);
  EXPECT_NEAR(largest_impulse_with_step(0.2, 0.6, icub),
              icub.mass * omega * omega * 0.1 * (0.031 * growth + 0.2 * std::exp(-omega * 0.5)) /
                  (growth - 1.0),
              1e-12);
  EXPECT_NEAR(largest_impulse_with_step(0.0, 0.6, icub), largest_impulse_standing(0.0, icub),
              1e-12);
}

TEST(StandingBound, RejectsInvalidPushes) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const auto with = [](auto change) {
    StandingPush push = icub;
    change(push);
    return push;
  };
  EXPECT_THROW(least_peak_angular_momentum(-1.0, icub), DefinitionError);
  EXPECT_THROW(least_peak_angular_momentum(nan, icub), DefinitionError);
  EXPECT_THROW(largest_impulse_standing(-1.0, icub), DefinitionError);
  EXPECT_THROW(largest_impulse_with_step(nan, 0.6, icub), DefinitionError);
  EXPECT_THROW(largest_impulse_with_step(0.1, 0.05, icub), DefinitionError);
  for (const StandingPush& push :
       {with([](auto& p) { p.mass = 0.0; }), with([&](auto& p) { p.height = nan; }),
        with([](auto& p) { p.distance_to_edge = -0.01; }), with([](auto& p) { p.duration = 0.0; }),
        with([](auto& p) { p.torque = -1.0; }), with([](auto& p) { p.settle_time = 0.05; })})
    EXPECT_THROW(least_peak_angular_momentum(1.0, push), DefinitionError);
}

}  // namespace
}  // namespace saltus::robots
