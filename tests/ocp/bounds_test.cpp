// Bounds given row by row arrive row by row, whatever the compiler makes of the constants.
#include <gtest/gtest.h>

#include "saltus/ocp/phase.hpp"
#include "tests/support/point_mass.hpp"

namespace saltus {
namespace {

using testing_support::Cart;

// gcc 12 with AVX-512 made [1, 1] of both (framework/cmake/SaltusTarget.cmake).
TEST(Bounds, EachRowKeepsItsOwn) {
  Phase<2, 1> phase{"block", Cart{}, exactly(1.0)};
  phase.reach("end", [](auto, auto x) { return x; }, {exactly(1.0), exactly(0.0)})
      .begin_with(
          "start", [](auto, auto x) { return x[0]; }, exactly(2.0));
  const Term& end = phase.definition().terms.front();
  ASSERT_EQ(end.bounds.size(), 2u);
  EXPECT_EQ(end.bounds[0], exactly(1.0));
  EXPECT_EQ(end.bounds[1], exactly(0.0));
}

}  // namespace
}  // namespace saltus
