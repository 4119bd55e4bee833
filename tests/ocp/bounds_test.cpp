// Tests that bounds given row by row are kept exactly, for all compiler optimisations of constants.
#include <gtest/gtest.h>

#include "saltus/ocp/phase.hpp"
#include "saltus/ocp/problem.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using testing_support::Cart;

// gcc 12 with AVX-512 computed [1, 1] for both (framework/cmake/SaltusTarget.cmake).
TEST(Bounds, EachRowKeepsItsBounds) {
  Phase<2, 1> phase{"block", Cart{}, exactly(1.0)};
  phase.reach("end", [](auto, auto x) { return x; }, {exactly(1.0), exactly(0.0)})
      .begin_with(
          "start", [](auto, auto x) { return x[0]; }, exactly(2.0));
  const Term& end = phase.definition().terms.front();
  ASSERT_EQ(end.bounds.size(), 2u);
  EXPECT_EQ(end.bounds[0], exactly(1.0));
  EXPECT_EQ(end.bounds[1], exactly(0.0));
}

TEST(Bounds, BoundsWithoutFiniteValueAreEmpty) {
  for (const Bounds& b : {exactly(infinity), at_least(infinity), at_most(-infinity),
                          exactly(-infinity), between(2.0, 1.0)})
    EXPECT_TRUE(b.is_empty()) << b.lower << " to " << b.upper;
  for (const Bounds& b : {unbounded(), at_least(1.0), at_most(-1.0), exactly(0.0)})
    EXPECT_FALSE(b.is_empty()) << b.lower << " to " << b.upper;
}

// Bounds of an unknown set by a finished phase also hold for the next phase that reads the unknown.
TEST(Bounds, BoundsOfAnUnknownOutliveTheirPhase) {
  const auto driven = [](const auto&, const auto&, const auto& u, const auto& p) {
    return std::decay_t<decltype(u)>(p[0] * u[0]);
  };
  Phase<1, 1, 1> a{"a", driven, exactly(1.0)}, b{"b", driven, exactly(1.0)};
  a.unknown("gain", Vec<double, 1>(0.5), between(0.0, 1.0));
  b.unknown("gain", Vec<double, 1>(0.5), between(-1.0, 5.0));
  OptimalControlProblem ocp("gain");
  ocp.start_at({0.0}).then(a).then(b);
  EXPECT_EQ(ocp.after(1).bounds_of_unknown("gain", 0), between(0.0, 1.0));
}

// Several threads evaluate a soft bound at once, as they do with formulas.
TEST(Bounds, SoftBoundsAreReentrant) {
  Phase<2, 1> phase{"block", Cart{}, exactly(1.0)};
  phase.bound_state(1, at_most(1.0), {}, soft("speed", 1.0));
  EXPECT_TRUE(phase.definition().terms.front().function.is_reentrant());
}

}  // namespace
}  // namespace saltus
