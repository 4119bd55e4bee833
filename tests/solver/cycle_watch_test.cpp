// Sequences of cost and violation that are cycles, and others that are not.
#include "saltus/solver/cycle_watch.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace saltus {
namespace {

// Number of iterates until the watch reports a cycle; 0: none within 200.
template <class Violation>
int iterates_until_cycling(CycleWatch& watch, Violation violation) {
  for (int i = 0; i < 200; ++i)
    if (watch.is_cycling(1.0, violation(i))) return i + 1;
  return 0;
}

TEST(CycleWatch, ReportsReturnsToPointsThatWereLeft) {
  CycleWatch watch;
  // Two points, each reached again after two steps: from the third iterate on, each is a return.
  const auto alternate = [](int i) { return i % 2 == 0 ? 8e-3 : 4e-2; };
  EXPECT_EQ(iterates_until_cycling(watch, alternate), 22);
  watch.restart();
  EXPECT_EQ(iterates_until_cycling(watch, alternate), 22);
  // A little progress in each round does not hide the cycle.
  watch.restart();
  const auto drift = [&](int i) { return alternate(i) * (1.0 - 1e-5 * i); };
  EXPECT_EQ(iterates_until_cycling(watch, drift), 22);
}

// Cycles with restorations take up to about 20 steps: far away, slowly back, and once more.
TEST(CycleWatch, ReportsLongCycles) {
  CycleWatch watch;
  const auto round = [](int i) { return 4e-2 * std::exp(-0.2 * (i % 20)); };
  EXPECT_EQ(iterates_until_cycling(watch, round), 40);
}

TEST(CycleWatch, ReportsNoProgressAndNoStagnation) {
  CycleWatch watch;
  EXPECT_EQ(iterates_until_cycling(watch, [](int i) { return std::exp(-0.2 * i); }), 0);
  watch.restart();  // a constant is stagnation, not a return
  EXPECT_EQ(iterates_until_cycling(watch, [](int) { return 8e-3; }), 0);
  watch.restart();  // alternates, but decreases
  EXPECT_EQ(
      iterates_until_cycling(watch, [](int i) { return std::exp(-0.01 * i) * (1.0 + i % 2); }), 0);
}

}  // namespace
}  // namespace saltus
