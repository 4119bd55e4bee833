// The contribution of one row to a KKT residual, against known values.
#include "saltus/qp/side_residual.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace saltus {
namespace {

struct Hard {
  double feasibility = 0.0, complementarity = 0.0;
};
Hard hard(double value, double lower, double upper, double multiplier) {
  Hard r;
  add_hard(value, lower, upper, multiplier, r.feasibility, r.complementarity);
  return r;
}

TEST(HardRow, MultiplierIsWeightedByTheDistanceToItsBound) {
  EXPECT_EQ(hard(0.5, 0.0, 2.0, 0.0).complementarity, 0.0);
  EXPECT_EQ(hard(0.5, 0.0, 2.0, 4.0).complementarity, 6.0);
  EXPECT_EQ(hard(0.5, 0.0, 2.0, -4.0).complementarity, 2.0);
  EXPECT_EQ(hard(2.0, 0.0, 2.0, 4.0).complementarity, 0.0);
  EXPECT_EQ(hard(2.25, 0.0, 2.0, 4.0).complementarity, 0.0);  // violated, with the right sign
  EXPECT_EQ(hard(0.5, 0.0, infinity, 4.0).complementarity, 4.0);
  EXPECT_EQ(hard(0.5, -infinity, 2.0, -4.0).complementarity, 4.0);
}

TEST(HardRow, ViolationIsTheDistanceToItsBound) {
  EXPECT_EQ(hard(0.5, 0.0, 2.0, 1.0).feasibility, 0.0);
  EXPECT_EQ(hard(2.25, 0.0, 2.0, 0.0).feasibility, 0.25);
  EXPECT_EQ(hard(-0.5, 0.0, 2.0, 0.0).feasibility, 0.5);
  EXPECT_EQ(hard(std::numeric_limits<double>::quiet_NaN(), 0.0, 2.0, 0.0).feasibility, infinity);
}

// This also holds if the equation is violated, on either side.
TEST(HardRow, TheMultiplierOfAnEquationIsFree) {
  for (const double multiplier : {-3.0, 3.0})
    for (const double value : {0.5, 1.0, 1.5}) {
      const Hard r = hard(value, 1.0, 1.0, multiplier);
      EXPECT_EQ(r.complementarity, 0.0);
      EXPECT_EQ(r.feasibility, std::abs(value - 1.0));
    }
}

struct Soft {
  double stationarity = 0.0, complementarity = 0.0;
};
Soft soft(double value, double l1, double l2, double multiplier, double lower = 0.0,
          double upper = 2.0) {
  Soft r;
  add_soft(value, lower, upper, l1, l2, multiplier, r.stationarity, r.complementarity);
  return r;
}

TEST(SoftRow, IsOptimalWhereTheMultiplierIsTheSlopeOfThePenalty) {
  for (const double sign : {1.0, -1.0}) {
    const double missed = 1.0 + 1.5 * sign;  // by 0.5
    EXPECT_EQ(soft(missed, 3.0, 2.0, 4.0 * sign).complementarity, 0.0);
    EXPECT_EQ(soft(missed, 3.0, 2.0, 4.0 * sign).stationarity, 0.0);
    // A multiplier that is too small by 1 gives a residual of the violation times 1.
    EXPECT_EQ(soft(missed, 3.0, 2.0, 3.0 * sign).complementarity, 0.5);
    // If the side is not reached, the residual is zero.
    EXPECT_EQ(soft(1.0, 3.0, 2.0, 2.0 * sign).complementarity, 2.0);
    // At the side, any multiplier up to the slope is optimal.
    EXPECT_EQ(soft(1.0 + sign, 3.0, 2.0, 2.5 * sign).complementarity, 0.0);
  }
}

TEST(SoftRow, MultiplierBeyondTheSlopeCountsTheSmallerError) {
  // Violated by 0.5 with a multiplier m below l2: complementarity m * 0.5 / l2.
  EXPECT_DOUBLE_EQ(soft(2.0, 1.0, 6.0, 1.5).complementarity, 0.125);
  EXPECT_EQ(soft(2.0, 1.0, 6.0, 1.5).stationarity, 0.0);
  // With l1 alone, or with a multiplier above l2, stationarity 0.5.
  EXPECT_EQ(soft(2.0, 1.0, 0.0, 1.5).stationarity, 0.5);
  EXPECT_EQ(soft(2.0, 1.0, 1.5, 1.5).stationarity, 0.5);
}

// At the slack, a multiplier beyond the slope leaves an error of complementarity only: the distance
// slack - miss times the multiplier, which is the residual of add_soft().
TEST(SoftRow, ItsSlackPermitsTheMultiplierWhereThatIsTheSmallerError) {
  EXPECT_EQ(soft_slack(0.5, 3.0, 2.0, 4.0), 0.5);   // the slope is the multiplier
  EXPECT_EQ(soft_slack(-0.5, 3.0, 2.0, 1.0), 0.0);  // not reached
  EXPECT_DOUBLE_EQ(1.5 * (soft_slack(0.0, 1.0, 6.0, 1.5) - 0.0),
                   soft(2.0, 1.0, 6.0, 1.5).complementarity);
  // With l1 alone, or with a multiplier above l2, the error stays one of stationarity.
  EXPECT_EQ(soft_slack(0.0, 1.0, 0.0, 1.5), 0.0);
  EXPECT_EQ(soft_slack(0.0, 1.0, 1.5, 1.5), 0.0);
  EXPECT_EQ(soft_slack(0.0, 0.0, 0.0, -1.0), 0.0);  // free, and the other side pushes
}

TEST(SoftRow, MultiplierWithoutABoundIsAnError) {
  EXPECT_EQ(soft(1.0, 3.0, 2.0, 2.5, 0.0, infinity).complementarity, 2.5);
  EXPECT_EQ(soft(1.0, 3.0, 2.0, -2.5, -infinity, 2.0).complementarity, 2.5);
}

}  // namespace
}  // namespace saltus
