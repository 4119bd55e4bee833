// Largest push that iCub could survive without a step, by the best controller of a linear pendulum
// with flywheel, from the initial state of the closed loop of push recovery.
//
// In the closed loop, 8 N s without a step cause a fall. This is a property of the push, and not of
// a weak controller, if no controller can recover. Here a linear program finds the largest impulse
// for which some trajectory of centre of pressure and angular momentum, known in advance, brings
// the capture point to rest above the left sole with |H| at most 1 Nms throughout.
#include <gtest/gtest.h>

#include <cmath>

#include "saltus/robots/icub/icub.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "tests/support/linear_program.hpp"
#include "tests/support/standing_bound.hpp"

namespace saltus {
namespace {

constexpr double claimed_fall = 8.0;      // N s
constexpr double largest_momentum = 1.0;  // Nms, the bound of "recovered"

// Lateral motion on the left sole, y to the left; the push goes to -y.
struct Start {
  double mass, height, com_y;                                   // kg, m, m
  Bounds sole_y;                                                // m
  double duration = 0.1, settle_time = 2.0, torque = infinity;  // s, s, Nm: no limit on H'
};

// Initial state of the simulation: CoM of the default posture, at rest.
Start closed_loop_start() {
  const robots::RobotDescription robot = icub();
  const robots::StandingPosture& posture = robot.default_posture();
  EXPECT_EQ(posture.name, "left_stance");
  return {.mass = robot.mass,
          .height = posture.com[2],
          .com_y = posture.com[1],
          .sole_y = robot.left_foot.y};
}

robots::StandingPush as_push(const Start& s) {
  return {.mass = s.mass,
          .height = s.height,
          .distance_to_edge = s.com_y - s.sole_y.lower,
          .duration = s.duration,
          .torque = s.torque,
          .settle_time = s.settle_time};
}

// Largest impulse, N s. Centre of pressure constant and H linear on intervals of `dt`; the capture
// point xi' = omega (xi - p) + (F + H'/z) / (m omega) is integrated exactly. H about the CoM, with
// the sign in which growing H pushes the CoM to +y.
double largest_impulse(const Start& s, double dt) {
  const double omega = pendulum_frequency(s.height);
  const double grow = std::exp(omega * dt);
  const double per_newton = (grow - 1.0) / (s.mass * omega * omega);
  const auto intervals = static_cast<int>(std::lround(s.settle_time / dt));
  const auto pushed = static_cast<int>(std::lround(s.duration / dt));

  testing::LinearProgram lp;
  const int impulse = lp.variable(at_least(0.0), -1.0);  // as large as possible
  int xi = lp.variable(exactly(s.com_y));
  int h = lp.variable(exactly(0.0));
  for (int k = 0; k < intervals; ++k) {
    const bool last = k + 1 == intervals;
    const int p = lp.variable(s.sole_y);
    const int next_xi = lp.variable(last ? s.sole_y : unbounded());
    const int next_h =
        lp.variable(last ? exactly(0.0) : between(-largest_momentum, largest_momentum));
    const double h_rate = per_newton / (s.height * dt);
    lp.row({{next_xi, 1.0},
            {xi, -grow},
            {p, grow - 1.0},
            {next_h, -h_rate},
            {h, h_rate},
            {impulse, k < pushed ? per_newton / s.duration : 0.0}},
           exactly(0.0));
    if (std::isfinite(s.torque))
      lp.row({{next_h, 1.0}, {h, -1.0}}, between(-s.torque * dt, s.torque * dt));
    xi = next_xi;
    h = next_h;
  }
  const testing::LinearProgramResult result = testing::solve(lp);
  EXPECT_TRUE(result.optimal);
  return -result.objective;
}

TEST(StandingClaim, NoControllerWithstandsTheLargerPush) {
  const double impulse = largest_impulse(closed_loop_start(), 0.005);
  EXPECT_LT(impulse, claimed_fall);
  EXPECT_NEAR(impulse, 7.03, 0.01);  // as documented
}

// The controller first moves the CoM above the sole's origin, a little farther from the edge.
TEST(StandingClaim, HoldsFromTheTargetOfTheController) {
  Start start = closed_loop_start();
  start.com_y = 0.0;
  const double impulse = largest_impulse(start, 0.005);
  EXPECT_LT(impulse, claimed_fall);
  EXPECT_NEAR(impulse, 7.43, 0.01);  // as documented
}

// The discrete program covers all controllers only in the limit of short intervals.
TEST(StandingClaim, TheClosedFormIsTheLimitOfTheLinearProgram) {
  for (const double com_y : {closed_loop_start().com_y, 0.0})
    for (const double torque :
         {infinity, 40.0}) {  // Nm; the second is the capacity of hips and torso
      Start start = closed_loop_start();
      start.com_y = com_y;
      start.torque = torque;
      const double limit = robots::largest_impulse_standing(largest_momentum, as_push(start));
      const double coarse = largest_impulse(start, 0.01), fine = largest_impulse(start, 0.0025);
      constexpr double solver_accuracy = 1e-6;  // N s
      EXPECT_LT(limit, claimed_fall);
      EXPECT_LE(coarse, fine + solver_accuracy);
      EXPECT_LE(fine, limit + solver_accuracy);
      EXPECT_GT(fine, 0.995 * limit);
    }
}

// Limit of the claim: the bound grows for a lower pendulum, so a robot that crouches to 0.5 m
// before the push could survive it.
TEST(StandingClaim, UsesTheHeightOfThePosture) {
  Start start = closed_loop_start();
  start.com_y = 0.0;
  start.height = 0.51;
  EXPECT_LT(robots::largest_impulse_standing(largest_momentum, as_push(start)), claimed_fall);
  start.height = 0.50;
  EXPECT_GT(robots::largest_impulse_standing(largest_momentum, as_push(start)), claimed_fall);
}

}  // namespace
}  // namespace saltus
