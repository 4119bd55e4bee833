// Motors that lag: closed forms of the first-order lag and of the ramp.
#include "saltus/robots/whole_body/motors.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

constexpr double step = 1e-3;  // s
constexpr double rounding = 1e-12;

// Command step from 1 to 3 Nm: mean torque in the last engine step.
double after(const robots::MotorOptions& options, int steps) {
  robots::Motors motors(options, 1, step);
  motors.command(VectorXd::Constant(1, 1.0));
  EXPECT_EQ(motors.step()[0], 1.0);  // the first acts at once
  motors.command(VectorXd::Constant(1, 3.0));
  double acting = 0.0;
  for (int k = 0; k < steps; ++k) acting = motors.step()[0];
  return acting;
}

TEST(Motors, FollowWithTheirBandwidth) {
  constexpr double bandwidth = 20.0;
  for (const int steps : {1, 8, 40}) {
    const double lags = 2.0 * std::numbers::pi * bandwidth * step;
    const double decay = (std::exp(-lags * (steps - 1)) - std::exp(-lags * steps)) / lags;
    EXPECT_NEAR(after({bandwidth, 0.0}, steps), 3.0 - 2.0 * decay, rounding);
  }
}

// A first-order lag follows a ramp with the delay 1 / (2 pi bandwidth), for any engine step. A
// command in steps adds half a step on average.
TEST(Motors, LagBehindARamp) {
  constexpr double rate = 100.0;  // Nm/s
  for (const double bandwidth : {20.0, 50.0, 200.0}) {
    double acting = 0.0;
    robots::Motors motors({bandwidth, 0.0}, 1, step);
    double wanted = 0.0;
    for (int k = 0; k < 300; ++k) {
      wanted = rate * (k + 0.5) * step;
      motors.command(VectorXd::Constant(1, wanted));
      acting = motors.step()[0];
    }
    const double lag = 1.0 / (2.0 * std::numbers::pi * bandwidth);
    EXPECT_NEAR((wanted - acting) / rate, lag, 1e-2 * lag + 1e-4 * step) << bandwidth;
  }
}

TEST(Motors, AreRateLimited) {
  constexpr double rate = 100.0;
  EXPECT_NEAR(after({0.0, rate}, 7), 1.65, rounding);
  EXPECT_NEAR(after({0.0, rate}, 25), 3.0, rounding);
}

TEST(Motors, AreIdealByDefault) {
  EXPECT_TRUE(robots::MotorOptions{}.is_ideal());
  EXPECT_EQ(after({}, 1), 3.0);
}

TEST(Motors, RejectInvalidOptions) {
  const auto make = [](const robots::MotorOptions& options, double h) {
    robots::Motors(options, 1, h);
  };
  EXPECT_THROW(make({-1.0, 0.0}, step), DefinitionError);
  EXPECT_THROW(make({0.0, infinity}, step), DefinitionError);
  EXPECT_THROW(make({}, 0.0), DefinitionError);
}

}  // namespace
}  // namespace saltus
