#include "saltus/robots/model/capsule.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"

namespace saltus {
namespace {

using Point = Vec<double, 3>;

constexpr std::uint64_t seed = 14;

Point random_point(Random& random, double size = 1.0) { return size * random.vector(3); }

double depth(const robots::Capsule& capsule, const Point& p) {
  return capsule.radius - (robots::closest_points(capsule, {p, p, 0.0}).first - p).norm();
}

// Random points on the surface of a capsule, including both end caps.
std::vector<Point> surface(const robots::Capsule& capsule, int count, Random& random) {
  std::vector<Point> points;
  const Point axis = (capsule.to - capsule.from).normalized();
  for (int i = 0; i < count; ++i) {
    const Point out = random_point(random).normalized();
    const Point around = (out - out.dot(axis) * axis).normalized();
    const double along = random.uniform(0.0, 1.0);
    points.push_back(capsule.from + along * (capsule.to - capsule.from) + capsule.radius * around);
    points.push_back((out.dot(axis) > 0.0 ? capsule.to : capsule.from) + capsule.radius * out);
  }
  return points;
}

// On a grid of one hundredth of the lengths, no other pair of points of the segments is closer.
TEST(Capsule, ClosestPointsHaveMinimumDistance) {
  Random random(seed);
  for (int k = 0; k < 200; ++k) {
    robots::Capsule a{random_point(random), random_point(random), 0.0};
    robots::Capsule b{random_point(random), random_point(random), 0.0};
    if (k % 5 == 0) b.to = b.from + 2.0 * (a.to - a.from);  // parallel
    if (k % 7 == 0) a.to = a.from;                          // a ball
    if (k % 11 == 0) b.to = b.from;
    const robots::SegmentPoints points = robots::closest_points(a, b);
    const double distance = (points.first - points.second).norm();
    double least = infinity;
    constexpr int cells = 100;
    for (int i = 0; i <= cells; ++i)
      for (int j = 0; j <= cells; ++j)
        least = std::min(
            least,
            (a.from + i * (a.to - a.from) / cells - b.from - j * (b.to - b.from) / cells).norm());
    EXPECT_LE(distance, least + 1e-12) << "seed " << seed << ", pair " << k;
    EXPECT_GE(distance, least - (a.length() + b.length()) / cells) << "pair " << k;
    EXPECT_GE(depth({a.from, a.to, 1e-9}, points.first), 0.0) << "pair " << k;
    EXPECT_GE(depth({b.from, b.to, 1e-9}, points.second), 0.0) << "pair " << k;
  }
}

TEST(Capsule, FitOfACapsuleReturnsIt) {
  Random random(seed);
  const robots::Capsule limb{{0.1, -0.2, 0.05}, {0.1, -0.1, 0.3}, 0.06};
  const std::vector<robots::Capsule> fit = robots::fit_capsules(surface(limb, 20000, random));
  ASSERT_EQ(fit.size(), 1U);
  // The points are about a millimetre apart.
  constexpr double near = 2e-3;
  EXPECT_NEAR(fit[0].radius, limb.radius, near);
  EXPECT_NEAR(fit[0].length(), limb.length(), 2.0 * near);
  EXPECT_LT((fit[0].middle() - limb.middle()).norm(), near);
}

TEST(Capsule, FitsContainAllPoints) {
  Random random(seed);
  for (int k = 0; k < 10; ++k) {
    std::vector<Point> points;
    const Point stretch = random_point(random, 0.3);
    for (int i = 0; i < 500; ++i) points.push_back(stretch.cwiseProduct(random_point(random)));
    const std::vector<robots::Capsule> fit = robots::fit_capsules(points);
    for (const Point& p : points) {
      double deepest = -infinity;
      for (const robots::Capsule& c : fit) deepest = std::max(deepest, depth(c, p));
      EXPECT_GE(deepest, -1e-12) << "seed " << seed << ", cloud " << k;
    }
  }
}

// A bend of two limbs, 0.4 m each, is split; one capsule would need a radius above 0.2 m.
TEST(Capsule, SplitsBentShapes) {
  Random random(seed);
  const robots::Capsule one{{0.0, 0.0, 0.0}, {0.4, 0.0, 0.0}, 0.04},
      two{{0.0, 0.0, 0.0}, {0.0, 0.4, 0.0}, 0.04};
  std::vector<Point> points = surface(one, 4000, random);
  for (const Point& p : surface(two, 4000, random)) points.push_back(p);
  const std::vector<robots::Capsule> fit = robots::fit_capsules(points);
  ASSERT_GE(fit.size(), 2U);
  double volume = 0.0;
  for (const robots::Capsule& c : fit) volume += c.volume();
  EXPECT_LT(volume, 2.0 * (one.volume() + two.volume()));
  EXPECT_EQ(robots::fit_capsules(points, 1).size(), 1U);
}

TEST(Capsule, FitsFlatSetsAndSinglePoints) {
  const Point p(1.0, 2.0, 3.0);
  const std::vector<robots::Capsule> ball = robots::fit_capsules({p});
  ASSERT_EQ(ball.size(), 1U);
  EXPECT_TRUE(ball[0].middle().isApprox(p));
  EXPECT_EQ(ball[0].radius, 1e-3);  // simulators refuse shapes without extent
  const std::vector<robots::Capsule> line =
      robots::fit_capsules({p, Point(p + Point::UnitX()), Point(p + 0.3 * Point::UnitX())});
  EXPECT_NEAR(line[0].length(), 1.0, 1e-9);
  EXPECT_THROW(robots::fit_capsules({}), DefinitionError);
}

}  // namespace
}  // namespace saltus
