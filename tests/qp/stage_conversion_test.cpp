// The sparse form of a program in stages is equivalent to it, point by point.
#include "tests/support/stage_conversion.hpp"

#include <gtest/gtest.h>

#include "saltus/core/error.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/random_qp.hpp"

namespace saltus {
namespace {

using namespace testing;

constexpr int seeds = 300;

// Rounding of sums of about ten products, with multipliers as their largest factors.
double rounding(const PrimalDualPoint& point) {
  return 1e-14 * (1.0 + point.lambda.lpNorm<Eigen::Infinity>() + point.z.lpNorm<Eigen::Infinity>());
}

TEST(StageConversion, KeepsOptimaAndTheirCost) {
  for (int seed = 1; seed <= seeds; ++seed) {
    const RandomQp random = random_qp(seed);
    const StageConversion conversion(random.qp);
    PrimalDualPoint point;
    conversion.convert(random.qp, random.optimum, point);
    EXPECT_LT(kkt_residual(conversion.sparse(), point).largest(), rounding(point))
        << seed << ": " << random.describe();
    EXPECT_NEAR(objective(conversion.sparse(), point.w), random.cost, 10.0 * rounding(point))
        << seed << ": " << random.describe();

    qp::StagePoint back(random.qp);
    conversion.convert(point, back);
    const double residual = kkt_residual(random.qp, back).largest();
    EXPECT_EQ(residual, kkt_residual(random.qp, random.optimum).largest()) << seed;
    EXPECT_EQ(objective(random.qp, back), random.cost) << seed;
  }
}

// Errors also agree at points that are not optimal.
TEST(StageConversion, KeepsCostsOfAllPoints) {
  for (int seed = 1; seed <= seeds; ++seed) {
    const RandomQp program = random_qp(seed);
    Random random(seed);
    qp::StagePoint point = program.optimum;
    for (qp::StagePoint::AtStage& p : point.stages) {
      p.x += random.vector(p.x.size());
      p.u += random.vector(p.u.size());
    }
    const StageConversion conversion(program.qp);
    PrimalDualPoint sparse;
    conversion.convert(program.qp, point, sparse);
    const double cost = objective(program.qp, point);
    EXPECT_NEAR(objective(conversion.sparse(), sparse.w), cost, 1e-12 * (1.0 + std::abs(cost)));
    const qp::StageQp::Residual residual = kkt_residual(program.qp, point);
    EXPECT_NEAR(kkt_residual(conversion.sparse(), sparse).feasibility, residual.feasibility,
                1e-14 * (10.0 + residual.feasibility));
  }
}

TEST(StageConversion, UpdatesWithoutAllocationAndRejectsOtherSizes) {
  const RandomQp random = random_qp(3, {.equality_rows = 1.0, .soft_rows = 1.0});
  qp::StageQp qp = random.qp;
  StageConversion conversion(qp);
  PrimalDualPoint point;
  conversion.convert(qp, random.optimum, point);
  qp::StagePoint back(qp);
  qp.stages[0].q[0] += 0.5;
  const AllocationCount count;
  conversion.update(qp);
  conversion.convert(qp, random.optimum, point);
  conversion.convert(point, back);
  EXPECT_EQ(count.made(), 0);
  EXPECT_NEAR(objective(conversion.sparse(), point.w), objective(qp, random.optimum), 1e-12);

  qp::StageQp other = qp;
  --other.stages.back().nx;
  EXPECT_THROW(conversion.update(other), DefinitionError);
}

}  // namespace
}  // namespace saltus
