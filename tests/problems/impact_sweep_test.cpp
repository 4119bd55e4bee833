// The optimum depends on the impact time without jumps, on and off the grid.
#include "benchmarks/impact_sweep.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <string>

namespace saltus::push_recovery {
namespace {

// Ipopt's tolerance is 1e-10; our recomputed residual uses other scaling factors.
constexpr double largest_kkt = 1e-8;

SweepPoint solved(ImpactSweep& sweep, double impact_time) {
  const SweepPoint point = sweep.solve(impact_time);
  EXPECT_TRUE(is_success(point.status)) << describe(point.status) << " at " << impact_time;
  EXPECT_LT(point.kkt, largest_kkt) << impact_time;
  return point;
}

std::vector<SweepPoint> solved(ImpactSweep& sweep, const std::vector<double>& times) {
  std::vector<SweepPoint> points;
  for (const double t : times) points.push_back(solved(sweep, t));
  return points;
}

std::vector<double> grid_times(double step) {
  std::vector<double> times;
  for (int k = 0; k * step < sweep_end + 0.5 * step; ++k)
    if (k * step > sweep_begin - same_instant && k * step < sweep_end + same_instant)
      times.push_back(k * step);
  return times;
}

std::vector<double> between_times(double begin, double end, double step) {
  std::vector<double> times;
  const long n = std::lround((end - begin) / step);
  for (long i = 0; i <= n; ++i) times.push_back(begin + (end - begin) * i / n);
  return times;
}

class Impact : public testing::TestWithParam<SweepVariant> {};

TEST_P(Impact, GridTimesAreNotSpecial) {
  ImpactSweep sweep(GetParam());
  constexpr double agreement = 1e-4;  // relative; the problem itself changes by 2e-5 in 1 us
  for (const double grid_time : grid_times(GetParam().step)) {
    const SweepPoint at = solved(sweep, grid_time);
    const double size = at.first_input.cwiseAbs().maxCoeff();
    // At 1 us, rounding decides whether the impact is at the node or a sliver away from it. Farther
    // away there is always a sliver.
    for (const double offset : {-1e-6, 1e-6, -1.1e-6, 1.1e-6}) {
      const SweepPoint near = solved(sweep, grid_time + offset);
      EXPECT_NEAR(near.cost, at.cost, agreement * at.cost) << grid_time << " + " << offset;
      EXPECT_LT((near.first_input - at.first_input).cwiseAbs().maxCoeff(), agreement * size)
          << grid_time << " + " << offset;
    }
  }
}

// Steps of 0.1 ms around every grid time and where the steps of 1 ms are steepest. If
// SALTUS_FULL_SWEEP is set, everywhere, as in benchmarks/impact_sweep_table.cpp.
TEST_P(Impact, NeighbouringCostsConverge) {
  ImpactSweep sweep(GetParam());
  const std::vector<double> times = sweep_times(1e-3);
  const Change coarse = largest_change(solved(sweep, times));
  const auto refine = [&](double begin, double end) {
    return largest_change(solved(sweep, between_times(begin, end, 1e-4)));
  };
  std::vector<Change> windows;
  if (std::getenv("SALTUS_FULL_SWEEP") != nullptr) {
    windows.push_back(refine(sweep_begin, sweep_end));
  } else {
    for (const double t : grid_times(GetParam().step))
      windows.push_back(refine(std::max(t - 5e-4, sweep_begin), std::min(t + 5e-4, sweep_end)));
    windows.push_back(refine(times[coarse.cost_step], times[coarse.cost_step + 1]));
    windows.push_back(refine(times[coarse.input_step], times[coarse.input_step + 1]));
  }
  Change fine;
  for (const Change& w : windows) {
    fine.cost = std::max(fine.cost, w.cost);
    fine.input = std::max(fine.input, w.input);
  }
  // A continuous piecewise smooth cost gives a ratio of ten, a jump gives one.
  EXPECT_LT(5.0 * fine.cost, coarse.cost);
  EXPECT_LT(5.0 * fine.input, coarse.input);
  RecordProperty("cost_change_1ms", std::to_string(coarse.cost));
  RecordProperty("cost_change_0.1ms", std::to_string(fine.cost));
  RecordProperty("input_change_1ms", std::to_string(coarse.input));
  RecordProperty("input_change_0.1ms", std::to_string(fine.input));
}

TEST_P(Impact, RoundingToTheGridGivesAStaircase) {
  ImpactSweep sweep(GetParam());
  const auto rounded = [&](double step) {
    std::vector<SweepPoint> points;
    for (const double t : sweep_times(step)) points.push_back(sweep.solve_rounded(t));
    return largest_change(points);
  };
  const Change coarse = rounded(1e-3), fine = rounded(1e-4);
  EXPECT_NEAR(fine.cost, coarse.cost, 1e-6 * coarse.cost);  // accuracy of the optimum
  EXPECT_GT(fine.cost, 0.05);  // 0.07 to 0.62, while the exact cost changes 0.003 in 0.1 ms
  RecordProperty("staircase_cost", std::to_string(coarse.cost));
  RecordProperty("staircase_input", std::to_string(coarse.input));
}

std::string test_name(const SweepVariant& v) {
  return std::to_string(std::lround(1e3 * v.step)) + "ms" + std::to_string(v.intervals) +
         (v.cost_rule == CostRule::nodes ? "Summed" : "Integrated") +
         (v.wrench_change > 0.0 ? "WithDifferences" : "");
}
INSTANTIATE_TEST_SUITE_P(Variants, Impact, testing::ValuesIn(sweep_variants()),
                         [](const auto& variant) { return test_name(variant.param); });

// Published heights of the largest step, two digits: node-summed costs, no first differences.
TEST(RoundedImpact, HasThePublishedSteps) {
  const auto height = [](double step) {
    ImpactSweep sweep({.step = step, .intervals = 15});
    std::vector<SweepPoint> points;
    for (const double t : sweep_times(1e-3)) points.push_back(sweep.solve_rounded(t));
    return largest_change(points).cost;
  };
  EXPECT_NEAR(height(0.01), 0.09, 0.005);
  EXPECT_NEAR(height(0.05), 0.54, 0.005);
}

}  // namespace
}  // namespace saltus::push_recovery
