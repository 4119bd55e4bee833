// Tests that the benchmark's program equals the program of the recipe.
#include "benchmarks/step_recovery_qp.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "benchmarks/measurement.hpp"
#include "benchmarks/step_recovery_kernels.hpp"

namespace saltus::bench {
namespace {

constexpr int beyond = 1 << 20;

struct Reference {
  int intervals, landing;
  double optimum;  // known to the nine printed digits
};

TEST(StepRecoveryQp, NominalOptimaMatchTheRecipe) {
  for (const Reference& r : {Reference{15, 7, 6.59199183},
                             {15, beyond, 7.38804372},
                             {15, 0, 7.78139492},
                             {30, 7, 3.48965944},
                             {60, 7, 3.44198312},
                             {150, 7, 5.77996231}}) {
    const qp::StageQp qp = step_recovery_qp({r.intervals, r.landing}, nominal_start());
    for (const bool fixed_sizes : {true, false}) {
      const auto solver = fixed_sizes
                              ? qp::make_riccati_solver(qp, from_standing(), step_recovery_kernels)
                              : qp::make_riccati_solver(qp);
      qp::StagePoint point = standing_guess(qp);
      const qp::QpResult result = solver->solve(qp, point, false);
      EXPECT_EQ(result.status, qp::QpStatus::optimal);
      EXPECT_LE(kkt_residual(qp, point).largest(), accepted_residual);
      // Half a unit of the last printed digit, or 1e-8 of the value.
      const double tolerance = std::max(0.5e-8, 1e-8 * r.optimum);
      EXPECT_NEAR(objective(qp, point), r.optimum, tolerance)
          << "N = " << r.intervals << ", landing at " << r.landing;
    }
  }
}

TEST(StepRecoveryQp, CapturePointRowsAreActiveForFastPushes) {
  for (std::uint64_t seed = 1; seed <= 20; ++seed) {
    const qp::StageQp qp = step_recovery_qp({}, random_start(seed, binding_push));
    const auto solver = qp::make_riccati_solver(qp, from_standing(), step_recovery_kernels);
    qp::StagePoint point = standing_guess(qp);
    ASSERT_EQ(solver->solve(qp, point, false).status, qp::QpStatus::optimal) << "seed " << seed;
    int binding = binding_rows(qp, point, qp.intervals(), 0);
    for (int k = StepRecovery{}.landing; k < qp.intervals(); ++k)
      binding += binding_rows(qp, point, k, 2);
    EXPECT_GE(binding, 1) << "seed " << seed;
  }
}

}  // namespace
}  // namespace saltus::bench
