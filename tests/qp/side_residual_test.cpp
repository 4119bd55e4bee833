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

TEST(HardRow, ItsMultiplierCountsByTheDistanceToItsSide) {
  EXPECT_EQ(hard(0.5, 0.0, 2.0, 0.0).complementarity, 0.0);
  EXPECT_EQ(hard(0.5, 0.0, 2.0, 4.0).complementarity, 6.0);
  EXPECT_EQ(hard(0.5, 0.0, 2.0, -4.0).complementarity, 2.0);
  EXPECT_EQ(hard(2.0, 0.0, 2.0, 4.0).complementarity, 0.0);
  EXPECT_EQ(hard(2.25, 0.0, 2.0, 4.0).complementarity, 0.0);  // missed, and pushed the right way
  EXPECT_EQ(hard(0.5, 0.0, infinity, 4.0).complementarity, 4.0);
  EXPECT_EQ(hard(0.5, -infinity, 2.0, -4.0).complementarity, 4.0);
}

TEST(HardRow, WhatItMissesIsItsViolation) {
  EXPECT_EQ(hard(0.5, 0.0, 2.0, 1.0).feasibility, 0.0);
  EXPECT_EQ(hard(2.25, 0.0, 2.0, 0.0).feasibility, 0.25);
  EXPECT_EQ(hard(-0.5, 0.0, 2.0, 0.0).feasibility, 0.5);
  EXPECT_EQ(hard(std::numeric_limits<double>::quiet_NaN(), 0.0, 2.0, 0.0).feasibility, infinity);
}

// Also where the equation is missed, to whichever side.
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
    // A multiplier that is too small, by 1, leaves the miss times that.
    EXPECT_EQ(soft(missed, 3.0, 2.0, 3.0 * sign).complementarity, 0.5);
    // Where the side is not reached there is none.
    EXPECT_EQ(soft(1.0, 3.0, 2.0, 2.0 * sign).complementarity, 2.0);
    // At the side anything up to the slope there.
    EXPECT_EQ(soft(1.0 + sign, 3.0, 2.0, 2.5 * sign).complementarity, 0.0);
  }
}

TEST(SoftRow, AMultiplierBeyondTheSlopeIsTheSmallerOfTwoErrors) {
  // Beyond by 0.5, multiplier below l2: m * 0.5 / l2 of complementarity.
  EXPECT_DOUBLE_EQ(soft(2.0, 1.0, 6.0, 1.5).complementarity, 0.125);
  EXPECT_EQ(soft(2.0, 1.0, 6.0, 1.5).stationarity, 0.0);
  // With l1 alone, or a multiplier above l2, 0.5 of stationarity.
  EXPECT_EQ(soft(2.0, 1.0, 0.0, 1.5).stationarity, 0.5);
  EXPECT_EQ(soft(2.0, 1.0, 1.5, 1.5).stationarity, 0.5);
}

TEST(SoftRow, WithoutASideAMultiplierCountsAsItIs) {
  EXPECT_EQ(soft(1.0, 3.0, 2.0, 2.5, 0.0, infinity).complementarity, 2.5);
  EXPECT_EQ(soft(1.0, 3.0, 2.0, -2.5, -infinity, 2.0).complementarity, 2.5);
}

}  // namespace
}  // namespace saltus
