// Upper faces of the ground: level, with a step, sloped, rough or ending.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/robots/whole_body/ground.hpp"
#include "tests/support/errors.hpp"

namespace saltus::robots {
namespace {

using Ground = Plant::Ground;

double height_at(const Ground& ground, double x, double y) {
  return robots::height_at(ground_boxes({.ground = ground}), x, y);
}

constexpr double rounding = 1e-12;
constexpr double edge = 0.18, landing = 0.06, drop = 0.05;  // m

TEST(Ground, IsLevelByDefault) {
  EXPECT_TRUE(Ground{}.is_level());
  EXPECT_EQ(ground_boxes({}).size(), 1u);
  for (const double y : {-9.0, -0.2, 0.0, 0.2, 9.0})
    EXPECT_NEAR(height_at({}, 0.0, y), 0.0, rounding);
}

// Walking speed 0.25 m/s.
TEST(Ground, IsLargeEnoughForAnHourOfWalking) {
  for (const double y : {-900.0, 900.0}) EXPECT_NEAR(height_at({}, 0.0, y), 0.0, rounding);
  EXPECT_EQ(ground_boxes({}).front().size[0], ground_boxes({}).front().size[1]);
}

TEST(Ground, StepBeginsAtItsEdgeOnEitherSide) {
  for (const double step : {-0.02, 0.02})
    for (const double side : {-1.0, 1.0}) {
      const Ground ground{.edge = side * edge, .height = step};
      for (const double y : {-9.0, 0.0, 0.17})  // in the direction of the step
        EXPECT_NEAR(height_at(ground, 0.0, side * y), 0.0, rounding)
            << step << ", " << side << ", " << y;
      for (const double y : {0.19, 9.0})
        EXPECT_NEAR(height_at(ground, 0.0, side * y), step, rounding)
            << step << ", " << side << ", " << y;
    }
}

// Both halves together have the extent of the level ground.
TEST(Ground, StepDoesNotChangeItsSize) {
  const double size = ground_boxes({}).front().size[1];
  for (const double y : {-edge, edge}) {
    double first = infinity, last = -infinity, sum = 0.0;
    for (const GroundBox& box : ground_boxes({.ground = {.edge = y, .height = 0.02}})) {
      first = std::min(first, box.pose.translation()[1] - 0.5 * box.size[1]);
      last = std::max(last, box.pose.translation()[1] + 0.5 * box.size[1]);
      sum += box.size[1];
    }
    EXPECT_NEAR(first, -0.5 * size, rounding);
    EXPECT_NEAR(last, 0.5 * size, rounding);
    EXPECT_NEAR(sum, size, rounding);
  }
}

TEST(Ground, SlopesAreAPlaneBeyondTheEdge) {
  for (const double side : {-1.0, 1.0})
    for (const double forward : {-0.2, 0.0, 0.13})
      for (const double away : {-0.07, 0.0, 0.2}) {
        const Ground ground{
            .edge = side * edge, .height = 0.01, .slope_forward = forward, .slope_side = away};
        for (const double x : {-3.0, 0.0, 0.4})
          for (const double distance : {0.01, landing, 1.5}) {
            const double height = 0.01 + forward * x + away * (distance - landing);
            EXPECT_NEAR(height_at(ground, x, side * (edge + distance)), height, rounding);
          }
        EXPECT_NEAR(height_at(ground, -3.0, 0.0), 0.0, rounding);
      }
}

TEST(Ground, LiesAheadOnRequest) {
  for (const double y : {-edge, edge})
    for (const double forward : {-0.09, 0.0, 0.09})
      for (const double left : {0.0, 0.05}) {
        const Ground ground{
            .edge = y, .ahead = true, .height = 0.02, .slope_forward = forward, .slope_side = left};
        for (const double side : {-0.7, 0.0, 0.3}) {
          EXPECT_NEAR(height_at(ground, edge - 0.001, side), 0.0, rounding);
          EXPECT_NEAR(height_at(ground, -5.0, side), 0.0, rounding);
          for (const double distance : {0.001, 0.5, 20.0})
            EXPECT_NEAR(height_at(ground, edge + distance, side),
                        0.02 + forward * distance + left * side, 100.0 * rounding);
        }
      }
}

TEST(Ground, EndsWithADrop) {
  for (const double side : {-1.0, 1.0}) {
    const Ground toes{.edge = side * edge, .height = 0.01, .end_forward = 0.05};
    EXPECT_NEAR(height_at(toes, 0.049, side * 0.3), 0.01, rounding);
    EXPECT_NEAR(height_at(toes, 0.051, side * 0.3), 0.01 - drop, rounding);
    EXPECT_NEAR(height_at(toes, 0.051, 0.0), 0.0, rounding);
    const Ground outer{.edge = side * edge, .slope_side = 0.1, .end_side = landing};
    EXPECT_NEAR(height_at(outer, 0.3, side * (edge + 0.059)), -0.1 * 0.001, rounding);
    EXPECT_NEAR(height_at(outer, 0.3, side * (edge + 0.061)), 0.1 * 0.001 - drop, rounding);
  }
}

TEST(Ground, TilesAreFlatAndRandom) {
  Ground ground{.edge = edge, .height = 0.02, .roughness = 0.01};
  Ground mirrored = ground, reseeded = ground, cut = ground;
  mirrored.edge = -edge;
  reseeded.seed = 2;
  cut.end_forward = 0.25;
  double lowest = infinity, highest = -infinity;
  for (double x = -1.95; x < 2.0; x += 0.1)
    for (double distance = 0.05; distance < 2.0; distance += 0.1) {
      const double y = edge + distance, height = height_at(ground, x, y);
      EXPECT_NEAR(height_at(ground, x + 0.04, y - 0.04), height, rounding);
      EXPECT_NEAR(height_at(mirrored, x, -y), height, rounding);
      EXPECT_NE(height_at(reseeded, x, y), height);
      EXPECT_NEAR(height_at(cut, x, y), x < 0.25 ? height : 0.02 - drop, rounding);
      lowest = std::min(lowest, height);
      highest = std::max(highest, height);
    }
  EXPECT_GE(lowest, 0.01);
  EXPECT_LT(lowest, 0.011);  // 800 tiles: the extremes are near the bounds
  EXPECT_LE(highest, 0.03);
  EXPECT_GT(highest, 0.029);
  for (const Vec<double, 2>& beyond : {Vec<double, 2>(2.1, 0.3), {-2.1, 0.3}, {0.0, 2.3}})
    EXPECT_NEAR(height_at(ground, beyond[0], beyond[1]), 0.02, rounding);
}

TEST(Ground, FrictionBelongsToThePartBeyondTheEdge) {
  for (const auto& [own, expected] : {std::pair(0.0, 0.7), std::pair(0.3, 0.3)}) {
    const auto boxes = ground_boxes({.friction = 0.7, .ground = {.height = 0.1, .friction = own}});
    ASSERT_EQ(boxes.size(), 2u);
    EXPECT_EQ(boxes[0].friction, 0.7);
    EXPECT_EQ(boxes[1].friction, expected);
  }
}

TEST(Ground, SoftPartsLieAboveARigidBottom) {
  const auto boxes = ground_boxes({.ground = {.edge = edge, .sink = 0.02}});
  ASSERT_EQ(boxes.size(), 3u);
  EXPECT_FALSE(boxes[0].is_soft);
  EXPECT_TRUE(boxes[1].is_soft);
  EXPECT_FALSE(boxes[2].is_soft);
  EXPECT_NEAR(robots::height_at(boxes, 0.0, 0.3), 0.0, rounding);
  EXPECT_NEAR(robots::height_at({boxes[2]}, 0.0, 0.3), -drop, rounding);
}

TEST(Ground, RejectsInvalidValues) {
  const auto expect_refusal = [](const Ground& ground, const char* member) {
    expect_error<DefinitionError>([&] { ground_boxes({.ground = ground}); }, {member, "set it to"});
  };
  const double nan = std::nan("");
  for (const double y : {0.0, nan, 1000.0}) expect_refusal({.edge = y, .height = 0.01}, "edge");
  expect_refusal({.height = nan}, "height");
  expect_refusal({.slope_forward = 1.1}, "slope_forward");
  expect_refusal({.slope_side = nan}, "slope_side");
  expect_refusal({.end_forward = infinity}, "end_forward");
  for (const double width : {0.0, nan}) expect_refusal({.end_side = width}, "end_side");
  for (const double bound : {-0.01, 0.06, nan}) expect_refusal({.roughness = bound}, "roughness");
  expect_refusal({.friction = -1.0}, "friction");
  expect_refusal({.sink = 0.06}, "sink");
}

}  // namespace
}  // namespace saltus::robots
