// Properties of the grid: it covers the phase, keeps its size, and has a node exactly at every
// event.
#include "saltus/transcription/grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "saltus/core/error.hpp"
#include "tests/support/event_problems.hpp"

namespace saltus {
namespace {

using namespace testing_support;

OptimalControlProblem three_events(const std::vector<double>& times) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.5)};
  phase.bound_input(0, exactly(0.0), Window{.to = event("a")})
      .bound_input(0, exactly(1.0), Window{.from = event("b"), .to = event("c")})
      .minimise("late", one, Window{.from = 1.2, .clock = Clock::absolute});
  OptimalControlProblem ocp("grid");
  ocp.schedule(Schedule({"1", "2", "3", "4"}, {{"a", times[0]}, {"b", times[1]}, {"c", times[2]}}))
      .start_at({0})
      .then(phase);
  return ocp;
}

TEST(Grid, LawsHoldForAnyEventTimes) {
  constexpr unsigned seed = 2024;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> anywhere(-0.3, 2.0);
  std::uniform_int_distribution<int> kind(0, 3);
  Grid grid(three_events({0.1, 0.2, 0.3}), {Mesh{.intervals = 15}});
  const int size = grid.intervals(0);
  EXPECT_EQ(size, 15 + 4);
  for (int trial = 0; trial < 2000; ++trial) {
    std::vector<double> times(3);
    for (double& t : times) {
      t = anywhere(random);
      if (kind(random) == 0) t = std::round(t * 10.0) / 10.0;         // at a node
      if (kind(random) == 0) t = std::round(t * 10.0) / 10.0 + 3e-7;  // almost
    }
    if (kind(random) == 0) times[1] = times[0];
    std::sort(times.begin(), times.end());
    const OptimalControlProblem problem = three_events(times);
    grid.place_events(problem.schedule(), 0.0);
    SCOPED_TRACE(testing::Message() << "seed " << seed << " trial " << trial << " events "
                                    << times[0] << " " << times[1] << " " << times[2]);
    ASSERT_EQ(grid.intervals(0), size);
    double covered = 0.0;
    int base_nodes = 0;
    for (int k = 0; k < size; ++k) {
      const Grid::Interval& interval = grid.interval(0, k);
      ASSERT_GE(interval.length0, 0.0);
      // There are no tiny intervals: each one is empty or longer than an instant.
      ASSERT_TRUE(interval.is_empty() || interval.length0 > same_instant);
      ASSERT_NEAR(interval.offset0, covered, 1e-12);
      covered += interval.length0;
    }
    ASSERT_NEAR(covered, 1.5, 1e-12);
    for (int i = 0; i <= 15; ++i) {
      bool found = false;
      for (int node = 0; node <= size; ++node)
        found = found || std::abs(grid.node_offset(0, node) - 0.1 * i) < 1e-12;
      base_nodes += found;
    }
    ASSERT_EQ(base_nodes, 16);  // the receding grid does not depend on the events
    for (const double t : times) {
      if (t < 0.0 || t > 1.5) continue;
      double nearest = infinity;
      bool is_event = false;
      for (int node = 0; node <= size; ++node) {
        const double distance = std::abs(grid.node_offset(0, node) - t);
        if (distance < nearest) is_event = grid.is_event(0, node);
        nearest = std::min(nearest, distance);
      }
      // Two mergers of at most one instant each: with a neighbouring event, and of that event with
      // a node.
      ASSERT_LE(nearest, 2.0 * same_instant);
      ASSERT_TRUE(is_event);
    }
  }
}

TEST(Grid, WindowLimitsAtBaseNodesNeedNoSlots) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.bound_input(0, exactly(0.0), Window{.from = 0.2, .to = 0.7})
      .minimise("late", one, Window{.from = 0.55});
  OptimalControlProblem ocp("grid");
  ocp.start_at({0}).then(phase);
  const Grid grid(ocp, {Mesh{.intervals = 10}});
  EXPECT_EQ(grid.intervals(0), 11);  // 0.55 only
  EXPECT_TRUE(grid.is_event(0, 2));
  EXPECT_FALSE(grid.is_event(0, 3));
}

TEST(Grid, KeepsNodesAtWindowLimitsForEveryDurationOfAFreePhase) {
  Phase<1, 1> phase{"free", Velocity{}, between(0.5, 4.0)};
  phase.bound_input(0, exactly(0.0), Window{.from = 0.1, .to = 0.4}).guess_duration(1.0);
  OptimalControlProblem ocp("grid");
  ocp.start_at({0}).then(phase);
  const Grid grid(ocp, {Mesh{.intervals = 10}});
  ASSERT_EQ(grid.intervals(0), 10);
  for (const double T : {0.5, 1.0, 3.3}) {
    double covered = 0.0;
    int limits = 0;
    for (int k = 0; k < 10; ++k) {
      const Grid::Interval& interval = grid.interval(0, k);
      EXPECT_NEAR(interval.offset(T), covered, 1e-12);
      EXPECT_GT(interval.length(T), 0.0);
      limits += std::abs(covered - 0.1) < 1e-12 || std::abs(covered - 0.4) < 1e-12;
      covered += interval.length(T);
    }
    EXPECT_NEAR(covered, T, 1e-12);
    EXPECT_EQ(limits, 2);
  }
}

}  // namespace
}  // namespace saltus
