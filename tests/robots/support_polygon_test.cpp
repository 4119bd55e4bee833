#include "saltus/robots/model/foot.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>
#include <random>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

using Points = Eigen::Matrix<double, Eigen::Dynamic, 2>;

TEST(Foot, CornersFollowPositionAndYaw) {
  const robots::FootRectangle foot{between(-0.05, 0.1), between(-0.03, 0.04)};
  Mat<double, 4, 2> expected;
  expected << 0.1, 0.04, -0.05, 0.04, -0.05, -0.03, 0.1, -0.03;
  EXPECT_EQ(robots::foot_corners(robots::SoleFrame{}, foot), expected);

  const robots::SoleFrame turned = robots::flat_sole({1.0, 2.0, 0.5}, std::numbers::pi / 2);
  expected << 1 - 0.04, 2.1, 1 - 0.04, 1.95, 1.03, 1.95, 1.03, 2.1;
  EXPECT_LT((robots::foot_corners(turned, foot) - expected).cwiseAbs().maxCoeff(), 1e-15);
  EXPECT_EQ(robots::foot_corners_3d(turned, foot).col(2), (Vec<double, 4>::Constant(0.5)));
  EXPECT_EQ(foot.mirrored().y, between(-0.04, 0.03));
}

TEST(SupportPolygon, EqualsTheOnlyFoot) {
  const robots::SupportPolygon polygon = robots::SupportPolygon::hull(robots::foot_corners(
      robots::flat_sole({0.3, -0.2, 0}, 0.4), {between(-0.05, 0.1), between(-0.03, 0.04)}));
  EXPECT_EQ(polygon.size(), 4);
  EXPECT_NEAR(polygon.area(), 0.15 * 0.07, 1e-15);
  const Vec<double, 3> centre =
      robots::flat_sole({0.3, -0.2, 0}, 0.4).to_world(Vec<double, 3>(0.025, 0.005, 0));
  EXPECT_NEAR(polygon.centroid().x(), 0.3 + centre.x(), 1e-15);
  EXPECT_NEAR(polygon.centroid().y(), -0.2 + centre.y(), 1e-15);
}

TEST(SupportPolygon, IsTheBoundingBoxOfTwoAlignedFeet) {
  const robots::FootRectangle foot{between(-0.05, 0.1), between(-0.03, 0.03)};
  // Instance of the published step-recovery cases: hull x [-0.05, 0.1], y [-0.15, 0.1].
  const robots::SupportPolygon polygon = robots::SupportPolygon::under(
      {{robots::flat_sole({0, 0.07, 0}), foot}, {robots::flat_sole({0, -0.12, 0}), foot}});
  ASSERT_EQ(polygon.size(), 4);  // the four inner corners lie on its sides
  EXPECT_EQ(polygon.vertices()[0], robots::Point2(-0.05, -0.15));
  EXPECT_NEAR(polygon.area(), 0.15 * 0.25, 1e-15);
  EXPECT_NEAR(polygon.centroid().x(), 0.025, 1e-15);
  EXPECT_NEAR(polygon.centroid().y(), -0.025, 1e-15);
  EXPECT_NEAR(polygon.signed_distance({0.0, 0.0}), -0.05, 1e-15);
  EXPECT_NEAR(polygon.signed_distance({0.13, 0.14}), 0.05, 1e-15);  // from the corner
  EXPECT_NEAR(polygon.signed_distance({0.0, -0.17}), 0.02, 1e-15);  // from the side
  EXPECT_TRUE(polygon.contains({0.0, 0.0}, 0.049));
  EXPECT_FALSE(polygon.contains({0.0, 0.0}, 0.051));
  EXPECT_TRUE(polygon.contains({0.101, 0.0}, -0.002));
}

TEST(SupportPolygon, HasUnitNormalsAndEightRowsForRotatedFeet) {
  const robots::FootRectangle foot{between(-0.05, 0.1), between(-0.03, 0.04)};
  const robots::SupportPolygon polygon =
      robots::SupportPolygon::under({{robots::flat_sole({0, 0.07, 0}, 0.3), foot},
                                     {robots::flat_sole({0.05, -0.15, 0}, -0.5), foot.mirrored()}});
  EXPECT_LE(polygon.size(), 8);
  const robots::SupportPolygon::HalfPlanes rows = polygon.half_planes(8);
  ASSERT_EQ(rows.rows(), 8);
  for (int i = 0; i < 8; ++i) EXPECT_NEAR(rows.A.row(i).norm(), 1.0, 1e-15);
  for (int i = polygon.size(); i < 8; ++i) {
    EXPECT_EQ(rows.A.row(i), rows.A.row(i - polygon.size()));
    EXPECT_EQ(rows.b[i], rows.b[i - polygon.size()]);
  }
  EXPECT_THROW(polygon.half_planes(polygon.size() - 1), DefinitionError);
}

TEST(SupportPolygon, OfTwoFeetInAControlLoopIsTheSame) {
  const robots::FootRectangle foot{between(-0.05, 0.1), between(-0.03, 0.04)};
  for (const double yaw : {0.0, 0.3, -0.5}) {
    const robots::PlacedFoot left{robots::flat_sole({0, 0.07, 0}, yaw), foot},
        right{robots::flat_sole({0.05, -0.15, 0}, -yaw), foot.mirrored()};
    const robots::SupportPolygon polygon = robots::SupportPolygon::under({left, right});
    const robots::SupportOfTwoFeet support(left, right);
    ASSERT_TRUE(support.is_valid());
    EXPECT_EQ(support.normals(), polygon.half_planes(8).A);
    EXPECT_EQ(support.offsets(), polygon.half_planes(8).b);
    EXPECT_EQ(support.centroid(), polygon.centroid());
  }
  const robots::SoleFrame lost =
      robots::flat_sole({std::numeric_limits<double>::quiet_NaN(), 0, 0});
  EXPECT_FALSE(robots::SupportOfTwoFeet({{}, foot}, {lost, foot}).is_valid());
}

TEST(SupportPolygon, ContainsItsPoints) {
  std::mt19937 random(11);
  std::normal_distribution<double> coordinate(0.0, 0.2);
  for (int trial = 0; trial < 200; ++trial) {
    Points points(3 + trial % 20, 2);
    for (int i = 0; i < points.size(); ++i) points(i) = coordinate(random);
    const robots::SupportPolygon polygon = robots::SupportPolygon::hull(points);
    for (int i = 0; i < points.rows(); ++i)
      EXPECT_LE(polygon.signed_distance(points.row(i).transpose()), 2e-9);  // hull's tolerance
    EXPECT_TRUE(polygon.contains(polygon.centroid()));
    const auto& v = polygon.vertices();
    for (int i = 0; i < polygon.size(); ++i) {
      const robots::Point2 a = v[(i + 1) % polygon.size()] - v[i];
      const robots::Point2 b = v[(i + 2) % polygon.size()] - v[(i + 1) % polygon.size()];
      EXPECT_GT(a.x() * b.y() - a.y() * b.x(), 0.0);  // counter-clockwise, strictly convex
    }
  }
}

TEST(SupportPolygon, DropsRepeatedAndCollinearPoints) {
  Points points(9, 2);
  points << 0, 0, 1, 0, 1, 1, 0, 1, 0.5, 0, 0.5, 1, 0, 0, 1, 1, 0.3, 0.2;
  const robots::SupportPolygon polygon = robots::SupportPolygon::hull(points);
  EXPECT_EQ(polygon.size(), 4);
  EXPECT_EQ(polygon.area(), 1.0);
}

TEST(SupportPolygon, RejectsLinesAndNan) {
  Points line(4, 2);
  line << 0, 0, 1, 1, 2, 2, 0.3, 0.3;
  EXPECT_THROW(robots::SupportPolygon::hull(line), DefinitionError);
  EXPECT_THROW(robots::SupportPolygon::hull(Points(0, 2)), DefinitionError);
  line(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(robots::SupportPolygon::hull(line), DefinitionError);
}

}  // namespace
}  // namespace saltus
