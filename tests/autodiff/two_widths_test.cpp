// A program and the library can target different processors. Objects of two vector widths, and a
// library of possibly a third, link into one program and compute correct results.
#include <gtest/gtest.h>

#include "two_widths.hpp"

namespace saltus::two_widths {
namespace {

// z = (t, x0 .. x3, u0, u1) = (0.5, 1, 2, 3, 4, 5, 6); y0 = x0 x1 x2 x3 u0 u1, y1 = x0 x2 + t u1.
void expect_right(const Derivatives& d) {
  EXPECT_EQ(d.value[0], 720.0);
  EXPECT_EQ(d.value[1], 6.0);
  // Row by row for both outputs: dy0/d(x, u), then dy1/dt, x0, x2, u1.
  const std::vector<double> jacobian{720.0, 360.0, 240.0, 180.0, 144.0, 120.0, 6.0, 3.0, 1.0, 0.5};
  double sum = 0.0, expected = 0.0;
  ASSERT_EQ(d.jacobian.size(), jacobian.size());
  for (std::size_t i = 0; i < jacobian.size(); ++i) sum += d.jacobian[i], expected += jacobian[i];
  EXPECT_EQ(sum, expected);
  // 720 / (z_i z_j) for each pair of inputs of y0. The entries of -y1 are x0 x2 and t u1.
  const double inputs[6] = {1, 2, 3, 4, 5, 6};
  double curvature = -2.0, found = 0.0;
  for (int i = 0; i < 6; ++i)
    for (int j = 0; j < i; ++j) curvature += 720.0 / (inputs[i] * inputs[j]);
  for (const double entry : d.hessian) found += entry;
  EXPECT_NEAR(found, curvature, 1e-10);  // a sum of fifteen quotients of order 100
}

TEST(TwoWidths, CanBeLinkedIntoOneProgram) {
#if defined(__x86_64__)
  if (!__builtin_cpu_supports("avx2")) GTEST_SKIP() << "this processor has no AVX2";
#endif
  const Derivatives wide = derivatives_wide(), narrow = derivatives_narrow();
  EXPECT_GT(wide.lanes, narrow.lanes);
  // The linker keeps one definition per name. Code for one layout must not replace the other.
  EXPECT_NE(wide.scalar, narrow.scalar);
  expect_right(narrow);
  expect_right(wide);
}

}  // namespace
}  // namespace saltus::two_widths
