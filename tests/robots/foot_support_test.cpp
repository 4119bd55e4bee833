// Estimated support of a standing foot: area, load, and the turn of a sole on its rim.
#include <gtest/gtest.h>

#include "saltus/robots/whole_body/foot_support.hpp"

namespace saltus::robots {
namespace {

constexpr double step = 0.002;    // s
constexpr double weight = 300.0;  // N
const FootRectangle sole{between(-0.05, 0.1), between(-0.04, 0.03)};

// Wrench with this load and centre of pressure, N and m.
FootSupport::Wrench pressing(double load, double forward, double left) {
  FootSupport::Wrench wrench = FootSupport::Wrench::Zero();
  wrench[2] = load;
  wrench[3] = left * load;
  wrench[4] = -forward * load;
  return wrench;
}

// A level sole with this angular velocity, rad/s.
DynamicsModel::SoleMotion turning(const Vec<double, 3>& speed) {
  DynamicsModel::SoleMotion motion;
  motion.pose = Eigen::Isometry3d::Identity();
  motion.twist.setZero();
  motion.twist.head<3>() = speed;
  return motion;
}

class Support : public testing::Test {
 protected:
  Support() : support(sole, weight, {.is_estimated = true}) { support.stand(weight); }
  void advance(double time, const Vec<double, 3>& turn, const FootSupport::Wrench& measured,
               const FootSupport::Wrench& commanded) {
    for (double t = 0.0; t < time; t += step)
      support.advance(step, turning(turn), measured, commanded);
  }

  FootSupport support;
};

const Vec<double, 3> at_rest = Vec<double, 3>::Zero();

// The right part of the sole is in the air: the sole turns over the edge, right side down.
TEST_F(Support, EndsWhereTheSoleTurnsOverAnEdge) {
  advance(0.1, {0.3, 0.0, 0.0}, pressing(weight, 0.0, -0.01), pressing(weight, 0.0, -0.04));
  EXPECT_NEAR(support.area().y.lower, -0.01, 1e-3);
  EXPECT_EQ(support.area().y.upper, sole.y.upper);
  EXPECT_EQ(support.area().x, sole.x);
  // The ground carries load further out.
  advance(0.1, at_rest, pressing(weight, 0.0, -0.03), pressing(weight, 0.0, -0.03));
  EXPECT_LE(support.area().y.lower, -0.03 + 1e-6);
}

TEST_F(Support, RegainsTheAreaAtRest) {
  advance(0.1, {0.0, 0.3, 0.0}, pressing(weight, 0.05, 0.0), pressing(weight, 0.09, 0.0));
  EXPECT_NEAR(support.area().x.upper, 0.05, 1e-3);
  advance(1.0, at_rest, pressing(weight, 0.0, 0.0), pressing(weight, 0.0, 0.0));
  EXPECT_NEAR(support.area().x.upper, 0.07, 2e-3);  // 0.02 m/s
  advance(5.0, at_rest, pressing(weight, 0.0, 0.0), pressing(weight, 0.0, 0.0));
  EXPECT_EQ(support.area().x, sole.x);
}

// Errors of the model move the centre of pressure, but the sole does not turn.
TEST_F(Support, KeepsTheAreaOfASoleThatDoesNotTurn) {
  advance(1.0, at_rest, pressing(weight, 0.0, 0.0), pressing(weight, 0.03, -0.03));
  EXPECT_EQ(support.area(), sole);
}

TEST_F(Support, TurnsASoleOnItsRimTowardsTheInside) {
  const FootSupport::Wrench inside = pressing(weight, 0.0, 0.0);
  advance(0.05, at_rest, pressing(weight, 0.0, sole.y.upper), inside);
  EXPECT_GT(support.turning()[0], 0.0);  // right side down
  EXPECT_EQ(support.turning()[1], 0.0);
  // The point that touches the ground is not accelerated.
  const Vec<double, 3> touched(0.0, sole.y.upper, 0.0);
  const Vec<double, 3> turn = support.turning().head<3>();
  EXPECT_LT((support.turning().tail<3>() + turn.cross(touched)).norm(), 0.05 * turn.norm() * 0.03);
  advance(0.05, at_rest, pressing(weight, 0.0, sole.y.lower), inside);
  EXPECT_LT(support.turning()[0], 0.0);
  advance(0.1, at_rest, pressing(weight, sole.x.upper, 0.0), inside);
  EXPECT_LT(support.turning()[1], 0.0);  // heel down
  EXPECT_EQ(support.turning()[0], 0.0);
  advance(0.1, at_rest, inside, inside);
  EXPECT_TRUE(support.turning().isZero(0.0));
  EXPECT_EQ(support.area(), sole);
}

// The measured centre of pressure leaves the rim while the sole turns, before the sole is flat.
TEST_F(Support, FindsNoEdgeWhileASoleTurnsFlat) {
  const Vec<double, 3> heel_down{0.0, -0.5, 0.0};
  const FootSupport::Wrench inside = pressing(0.3 * weight, 0.0, 0.0);
  advance(0.05, at_rest, pressing(0.3 * weight, sole.x.upper, 0.0), inside);
  advance(0.02, heel_down, pressing(0.3 * weight, 0.09, 0.0), inside);
  EXPECT_LT(support.turning()[1], 0.0);
  advance(0.04, heel_down, pressing(0.3 * weight, 0.05, 0.0), inside);
  EXPECT_EQ(support.area(), sole);
}

// The front of the sole stands on a step, and its heel is in the air.
TEST_F(Support, TurnsASoleThatSeeksTheGround) {
  const double load = 0.2 * weight;
  const FootSupport::Wrench on_edge = pressing(load, 0.06, 0.0), middle = pressing(load, 0.0, 0.0);
  support.stand(load);
  advance(0.05, at_rest, on_edge, middle);
  EXPECT_TRUE(support.turning().isZero(0.0));
  support.stand(load, true);
  advance(0.05, at_rest, on_edge, middle);
  EXPECT_LT(support.turning()[1], 0.0);  // heel down
  advance(0.1, {0.0, -0.5, 0.0}, on_edge, middle);
  EXPECT_EQ(support.area(), sole);  // no edge is found while the sole turns
  // Once the ground supports the heel and the turn is forgotten, a later turn finds the edge.
  advance(1.0, at_rest, pressing(weight, 0.0, 0.0), pressing(weight, 0.0, 0.0));
  EXPECT_TRUE(support.turning().isZero(0.0));
  advance(0.1, {0.0, 0.3, 0.0}, pressing(weight, 0.05, 0.0), pressing(weight, 0.09, 0.0));
  EXPECT_NEAR(support.area().x.upper, 0.05, 1e-3);
}

TEST_F(Support, AFootThatHasLandedTakesLoadAsItIsCarried) {
  EXPECT_EQ(support.most_load(), infinity);
  support.stand(0.0);
  EXPECT_EQ(support.most_load(), 0.3 * weight);
  advance(0.1, at_rest, pressing(0.2 * weight, 0.0, 0.0), pressing(0.3 * weight, 0.0, 0.0));
  EXPECT_NEAR(support.most_load(), 0.6 * weight, 1.0);
  advance(0.1, at_rest, pressing(0.5 * weight, 0.0, 0.0), pressing(0.6 * weight, 0.0, 0.0));
  EXPECT_EQ(support.most_load(), infinity);
}

// A level sole that sinks by `depth` under its weight lands within 0.1 s. Its left edge sinks by
// `more`.
void land(FootSupport& support, double depth, double more) {
  support.stand(0.1 * weight);
  DynamicsModel::SoleMotion motion = turning({0.0, 0.0, 0.0});
  constexpr double time = 0.1;
  motion.twist[0] = -more / sole.y.upper / time;
  motion.twist[5] = -depth / time;
  for (double t = 0.0; t < time; t += step) {
    const FootSupport::Wrench pressed = pressing(weight * t / time, 0.0, 0.0);
    support.advance(step, motion, pressed, pressed);
  }
}

TEST_F(Support, FindsSoftGroundByTheSinkOfAFootThatTakesLoad) {
  land(support, 0.0, 0.003);  // it turns about the point that carries load
  EXPECT_EQ(support.area(), sole);
  land(support, 0.001, 0.0);
  EXPECT_EQ(support.area(), sole);
  land(support, 0.003, 0.0);
  const FootRectangle middle{between(-0.0125, 0.0625), between(-0.0225, 0.0125)};
  EXPECT_NEAR(support.area().x.lower, middle.x.lower, 1e-12);
  EXPECT_NEAR(support.area().x.upper, middle.x.upper, 1e-12);
  EXPECT_NEAR(support.area().y.lower, middle.y.lower, 1e-12);
  EXPECT_NEAR(support.area().y.upper, middle.y.upper, 1e-12);
  // A turn shows no edge here.
  advance(0.1, {0.3, 0.1, 0.2}, pressing(weight, 0.0, -0.01), pressing(weight, 0.0, -0.04));
  EXPECT_NEAR(support.area().y.lower, middle.y.lower, 1e-12);
  support.stand(weight);
  EXPECT_EQ(support.area(), sole);
}

// The ground resists a turn like a pad of springs below the sole.
TEST_F(Support, TurnsASoleOnSoftGroundUntilItsPressureIsTheCommandedOne) {
  land(support, 0.003, 0.0);
  const FootSupport::Wrench commanded = pressing(weight, 0.0, -0.01);
  advance(0.1, {0.3, 0.1, 0.2}, commanded, commanded);
  // 20 of 50 1/s of the damping are compensated, except about the normal.
  EXPECT_LT((support.turning().head<3>() - Vec<double, 3>(6.0, 2.0, 0.0)).norm(), 1e-3);
  advance(0.1, at_rest, pressing(weight, 0.0, -0.008), commanded);
  const double width = 0.07, stiffness = weight / 0.003 * width * width / 12.0;  // Nm/rad
  const double rate = 0.002 * weight / stiffness / 0.1;                          // rad/s
  // The filtered load lags behind the sink, so the ground seems softer.
  EXPECT_NEAR(support.turning()[0], 30.0 * rate, 0.25 * 30.0 * rate);
  EXPECT_NEAR(support.turning()[1], 0.0, 1e-3);
}

// 35 of 50 1/s of the damping are compensated until the foot has carried load.
TEST_F(Support, LetsAFootThatTakesLoadSink) {
  DynamicsModel::SoleMotion motion = turning(at_rest);
  const FootSupport::Wrench pressed = pressing(0.05 * weight, 0.0, 0.0);
  support.stand(0.0);
  motion.twist[5] = -0.1;
  support.advance(step, motion, pressed, pressed);
  EXPECT_NEAR(support.turning()[5], -3.5, 1e-12);
  motion.twist[5] = 0.1;
  support.advance(step, motion, pressed, pressed);
  EXPECT_EQ(support.turning()[5], 0.0);
  support.stand(weight);
  motion.twist[5] = -0.1;
  support.advance(step, motion, pressing(weight, 0.0, 0.0), pressing(weight, 0.0, 0.0));
  EXPECT_EQ(support.turning()[5], 0.0);
}

TEST_F(Support, TakesSoftGroundForRigidIfThePressureLeavesTheMiddle) {
  land(support, 0.003, 0.0);
  const FootSupport::Wrench inside = pressing(weight, 0.0, 0.018);  // by 5.5 mm outside
  advance(0.2, at_rest, inside, inside);
  EXPECT_LT(support.area().y.upper, 0.02);
  const FootSupport::Wrench outside = pressing(weight, 0.0, 0.03);
  advance(0.2, at_rest, outside, outside);
  EXPECT_EQ(support.area(), sole);
  EXPECT_TRUE(support.turning().isZero(0.0));
}

TEST(FootSupport, EstimatesNothingUnlessRequested) {
  FootSupport support(sole, weight, {});
  support.stand(0.0);
  for (int i = 0; i < 100; ++i)
    support.advance(step, turning({0.3, 0.0, 0.0}), pressing(weight, 0.0, -0.01),
                    pressing(weight, 0.0, -0.04));
  EXPECT_EQ(support.area(), sole);
  EXPECT_EQ(support.most_load(), infinity);
  EXPECT_TRUE(support.turning().isZero(0.0));
}

}  // namespace
}  // namespace saltus::robots
