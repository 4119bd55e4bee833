// Upper faces of the ground, level or with a step.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "saltus/core/error.hpp"
#include "saltus/robots/whole_body/ground.hpp"

namespace saltus {
namespace {

// Height of the ground at (0, y), -infinity if there is none.
double height_at(const robots::Plant::Options& options, double y) {
  double height = -infinity;
  for (const robots::GroundBox& box : robots::ground_boxes(options)) {
    if (std::abs(y - box.centre[1]) > 0.5 * box.size[1]) continue;
    height = std::max(height, box.centre[2] + 0.5 * box.size[2]);
  }
  return height;
}

constexpr double rounding = 1e-12;

TEST(Ground, IsLevelByDefault) {
  EXPECT_EQ(robots::ground_boxes({}).size(), 1u);
  for (const double y : {-9.0, -0.2, 0.0, 0.2, 9.0}) EXPECT_NEAR(height_at({}, y), 0.0, rounding);
}

// Walking speed 0.25 m/s.
TEST(Ground, IsLargeEnoughForAnHourOfWalking) {
  for (const double y : {-900.0, 900.0}) EXPECT_NEAR(height_at({}, y), 0.0, rounding);
  EXPECT_EQ(robots::ground_boxes({}).front().size[0], robots::ground_boxes({}).front().size[1]);
}

TEST(Ground, StepBeginsAtItsEdgeOnEitherSide) {
  robots::Plant::Options options;
  for (const double step : {-0.02, 0.02})
    for (const double side : {-1.0, 1.0}) {
      options.ground_step = step;
      options.ground_edge = side * 0.18;
      for (const double y : {-9.0, 0.0, 0.17})  // in the direction of the step
        EXPECT_NEAR(height_at(options, side * y), 0.0, rounding)
            << step << ", " << side << ", " << y;
      for (const double y : {0.19, 9.0})
        EXPECT_NEAR(height_at(options, side * y), step, rounding)
            << step << ", " << side << ", " << y;
    }
}

// Both halves together have the extent of the level ground.
TEST(Ground, StepDoesNotChangeItsSize) {
  const double size = robots::ground_boxes({}).front().size[1];
  robots::Plant::Options options;
  options.ground_step = 0.02;
  for (const double edge : {-0.18, 0.18}) {
    options.ground_edge = edge;
    double first = infinity, last = -infinity, sum = 0.0;
    for (const robots::GroundBox& box : robots::ground_boxes(options)) {
      first = std::min(first, box.centre[1] - 0.5 * box.size[1]);
      last = std::max(last, box.centre[1] + 0.5 * box.size[1]);
      sum += box.size[1];
    }
    EXPECT_NEAR(first, -0.5 * size, rounding);
    EXPECT_NEAR(last, 0.5 * size, rounding);
    EXPECT_NEAR(sum, size, rounding);
  }
}

TEST(Ground, RejectsInvalidValues) {
  robots::Plant::Options options;
  options.ground_step = 0.01;
  options.ground_edge = 0.0;
  EXPECT_THROW(robots::ground_boxes(options), DefinitionError);
}

}  // namespace
}  // namespace saltus
