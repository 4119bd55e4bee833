// The structured solver in each vector width. There is one build per width, with all sources
// compiled for it. The test is skipped if the machine does not support the width.
#include <gtest/gtest.h>

#include "tests/qp/vector_width_checks.hpp"

namespace saltus {
namespace {

using namespace testing;

class VectorWidth : public ::testing::Test {
 protected:
  void SetUp() override {
#if SALTUS_LANES == 8
    const bool has_it = __builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
                        __builtin_cpu_supports("avx512bw") && __builtin_cpu_supports("avx512vl");
#elif SALTUS_LANES == 4
    const bool has_it = __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma") &&
                        __builtin_cpu_supports("bmi2");
#else
    const bool has_it = true;
#endif
    if (!has_it) GTEST_SKIP() << "this machine has no vectors of " << SALTUS_LANES << " doubles";
  }

  static void expect_solved(const WidthReport& report) {
    EXPECT_EQ(report.lanes, SALTUS_LANES);
    EXPECT_EQ(report.failed, 0) << "of " << report.programs << ", first with seed "
                                << report.first_failed;
    EXPECT_LE(report.worst_cost, 1e-8);
    EXPECT_LE(report.worst_residual, 1e-8);
  }
};

TEST_F(VectorWidth, SolvesRandomPrograms) {
  expect_solved(solve_random_programs(2000, /*fixed_sizes=*/false));
}

TEST_F(VectorWidth, SolvesRandomProgramsWithFixedSizes) {
  expect_solved(solve_random_programs(100, /*fixed_sizes=*/true));
}

TEST_F(VectorWidth, SolvesProgramsWithPreviousInputsAsStates) {
  expect_solved(solve_with_previous_inputs(200));
}

TEST_F(VectorWidth, KernelsMultiply) { EXPECT_LT(worst_product_error(), 1e-14); }

}  // namespace
}  // namespace saltus
