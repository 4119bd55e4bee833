// The closed forms of the linear inverted pendulum, against numbers computed independently.
#include "saltus/robots/model/capture_point.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

namespace saltus {
namespace {

constexpr double exact = 1e-12;  // the reference numbers have 15 digits

TEST(CapturePoint, MatchesThePendulumAtRestHeight) {
  const double omega = pendulum_frequency(0.53);
  EXPECT_NEAR(omega, 4.30225916958337, exact);
  const robots::PendulumState<double> start{-0.05, 0.4};
  EXPECT_NEAR(robots::orbital_energy(start, 0.0, omega), 0.0568632075471698, exact);
  EXPECT_NEAR(capture_point(start.position, start.velocity, omega), 0.0429744081500177, exact);
}

TEST(CapturePoint, PropagatesWithThePendulum) {
  const double omega = pendulum_frequency(0.53);
  const robots::PendulumState<double> end =
      robots::propagate_pendulum({-0.05, 0.4}, 0.0, omega, 0.6);
  EXPECT_NEAR(end.position, 0.278544706479575, exact);
  EXPECT_NEAR(end.velocity, 1.24491795282536, exact);
  const double xi = robots::propagate_capture_point(0.0429744081500177, 0.0, omega, 0.6);
  EXPECT_NEAR(xi, 0.567908481127747, exact);
  EXPECT_NEAR(capture_point(end.position, end.velocity, omega), 0.567908481127747, exact);
  EXPECT_NEAR(robots::orbital_energy(end, 0.0, omega), 0.0568632075471698, exact);
}

TEST(CapturePoint, IsRelativeToTheCentreOfPressure) {
  const double omega = pendulum_frequency(0.6);
  const double p = 0.13;
  const robots::PendulumState<double> end = robots::propagate_pendulum({0.1, -0.2}, p, omega, 0.4);
  const robots::PendulumState<double> shifted =
      robots::propagate_pendulum({0.1 - p, -0.2}, 0.0, omega, 0.4);
  EXPECT_NEAR(end.position, shifted.position + p, exact);
  EXPECT_NEAR(end.velocity, shifted.velocity, exact);
  EXPECT_NEAR(robots::orbital_energy(end, p, omega), robots::orbital_energy({0.1, -0.2}, p, omega),
              exact);
  const Vec<double, 2> xi =
      capture_point(Vec<double, 2>(0.1, 0.3), Vec<double, 2>(-0.2, 0.0), omega);
  EXPECT_NEAR(xi[0], 0.1 - 0.2 / omega, exact);
  EXPECT_EQ(xi[1], 0.3);
  EXPECT_NEAR(robots::propagate_capture_point(xi, Vec<double, 2>(p, 0.3), omega, 0.4)[0],
              capture_point(end.position, end.velocity, omega), exact);
}

// A horizontal ground impulse J below the CoM adds angular momentum, dH = (0, 0, -z) x J, and
// velocity, J / m. It does not change the capture point at rest.
TEST(CapturePoint, RestRemovesTheFlywheelContribution) {
  constexpr double mass = 33.0;  // kg
  const Vec<double, 3> com(0.02, -0.03, 0.55), velocity(0.2, -0.4, 0.1);
  const double omega = pendulum_frequency(com[2]);
  const Vec<double, 2> still =
      robots::capture_point_at_rest(com, velocity, Vec<double, 3>::Zero(), mass, omega);
  EXPECT_LT((still - capture_point<double, 2>(com.head<2>(), velocity.head<2>(), omega)).norm(),
            exact);
  const Vec<double, 3> impulse(3.0, -2.0, 0.0), arm(0.0, 0.0, -com[2]);
  const Vec<double, 2> spinning = robots::capture_point_at_rest(com, velocity + impulse / mass,
                                                                arm.cross(impulse), mass, omega);
  EXPECT_LT((spinning - still).norm(), exact);
  // On a ground step, the pendulum height is measured from the step.
  const Vec<double, 3> raised(com[0], com[1], com[2] + 0.1);
  const Vec<double, 2> on_a_step = robots::capture_point_at_rest(raised, velocity + impulse / mass,
                                                                 arm.cross(impulse), mass, omega);
  EXPECT_LT((on_a_step - still).norm(), exact);
}

TEST(CapturePoint, MarginsOfNStepsMatchTheReference) {
  const double omega = pendulum_frequency(0.53);
  const robots::StepLimits point_foot{
      .longest_step = 0.4, .shortest_time = 0.3, .foot_radius = 0.0};
  const double point[] = {0.0,
                          0.110033712513468,
                          0.140302257237209,
                          0.148628658108042,
                          0.150919120107274,
                          0.151549190200141};
  for (int n = 0; n < 6; ++n)
    EXPECT_NEAR(robots::capturability_margin(n, point_foot, omega), point[n], exact)
        << n << " steps";
  EXPECT_NEAR(robots::capturability_limit(point_foot, omega), 0.151788283344598, exact);
  EXPECT_NEAR(robots::capturability_margin(200, point_foot, omega), 0.151788283344598, exact);

  const robots::StepLimits foot{.longest_step = 0.4, .shortest_time = 0.3, .foot_radius = 0.05};
  const double flat[] = {0.05, 0.160033712513468, 0.190302257237209, 0.198628658108042};
  for (int n = 0; n < 4; ++n)
    EXPECT_NEAR(robots::capturability_margin(n, foot, omega), flat[n], exact) << n << " steps";
  EXPECT_NEAR(robots::capturability_limit(foot, omega), 0.201788283344598, exact);
}

}  // namespace
}  // namespace saltus
