// Tests that quantiles are exact to the width of a bucket.
#include "saltus/mpc/receding_horizon.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <vector>

namespace saltus {
namespace {

TEST(LatencyHistogram, QuantileErrorIsAtMostOneBucket) {
  std::mt19937 random(3);
  std::lognormal_distribution<double> any(std::log(1e-4), 1.0);
  std::vector<double> values;
  LatencyHistogram h;
  for (int i = 0; i < 10000; ++i) {
    values.push_back(any(random));
    h.add(values.back());
  }
  std::sort(values.begin(), values.end());
  for (const double f : {0.01, 0.5, 0.9, 0.99, 0.999}) {
    const double exact = values[static_cast<std::size_t>(std::ceil(f * 10000.0)) - 1];
    EXPECT_GE(h.quantile(f), exact) << f;
    EXPECT_LE(h.quantile(f), 1.126 * exact) << f;  // one of eight steps per octave
  }
  EXPECT_EQ(h.max(), values.back());
  EXPECT_EQ(h.quantile(1.0), h.max());
  EXPECT_EQ(h.count(), 10000);
}

TEST(LatencyHistogram, CountsOutliersInTheEndBuckets) {
  LatencyHistogram h;
  EXPECT_EQ(h.median(), 0.0);
  for (const double t : {0.0, -1.0, 1e-12, 1e6, std::nan("")}) h.add(t);
  EXPECT_EQ(h.count(), 5);
  EXPECT_EQ(h.max(), 1e6);
  EXPECT_LT(h.median(), 1e-7);
}

TEST(LatencyHistogram, MergeEqualsJointCount) {
  LatencyHistogram a, b, both;
  for (int i = 1; i < 100; ++i) {
    (i % 2 == 0 ? a : b).add(1e-5 * i);
    both.add(1e-5 * i);
  }
  a.merge(b);
  for (const double f : {0.1, 0.5, 0.99}) EXPECT_EQ(a.quantile(f), both.quantile(f));
  EXPECT_EQ(a.max(), both.max());
  EXPECT_EQ(a.count(), both.count());
}

}  // namespace
}  // namespace saltus
