// The generators of random programs satisfy their documented properties.
#include "tests/support/random_qp.hpp"

#include <gtest/gtest.h>

#include <map>

#include "tests/support/unsolvable_qp.hpp"

namespace saltus {
namespace {

using namespace testing;

constexpr int seeds = 1000;

double largest_multiplier(const qp::StagePoint& point) {
  double largest = 0.0;
  const auto see = [&](const VectorXd& v) {
    if (v.size() > 0) largest = std::max(largest, v.lpNorm<Eigen::Infinity>());
  };
  for (const qp::StagePoint::AtStage& p : point.stages) {
    see(p.costate);
    see(p.u_bound);
    if (&p != &point.stages.front()) see(p.x_bound);
    for (const VectorXd& group : p.group) see(group);
  }
  return largest;
}

TEST(RandomQp, OptimaAreOptimalWithMargins) {
  int degenerate = 0, rank_deficient = 0, active = 0;
  for (int seed = 1; seed <= seeds; ++seed) {
    const RandomQp random = random_qp(seed);
    const double multiplier = largest_multiplier(random.optimum);
    EXPECT_LT(kkt_residual(random.qp, random.optimum).largest(), 1e-14 * (20.0 + 10.0 * multiplier))
        << seed << ": " << random.describe();
    EXPECT_GE(random.margin, 0.99e-6) << seed;  // rounding of sides near 1
    EXPECT_LE(multiplier, 2.01e6) << seed;
    degenerate += random.degenerate;
    rank_deficient += random.rank_deficient;
    for (const qp::StagePoint::AtStage& p : random.optimum.stages)
      active += static_cast<int>((p.u_bound.array() != 0.0).count());
  }
  // Probabilities of 15 and 10 percent.
  EXPECT_NEAR(degenerate, 0.15 * seeds, 40);
  EXPECT_NEAR(rank_deficient, 0.10 * seeds, 40);
  EXPECT_GT(active, seeds);
}

TEST(RandomQp, IsSeeded) {
  EXPECT_EQ(random_qp(5).cost, random_qp(5).cost);
  EXPECT_NE(random_qp(5).cost, random_qp(6).cost);
}

TEST(UnboundedQp, DirectionDecreasesTheCostAndIsFeasible) {
  std::map<std::string, int> kinds;
  for (int seed = 1; seed <= seeds; ++seed) {
    const UnboundedQp random = unbounded_qp(seed);
    ++kinds[random.proof];
    const double start = objective(random.qp, random.feasible);
    EXPECT_LT(kkt_residual(random.qp, random.feasible).feasibility, 1e-12) << seed;
    for (const double s : {1.0, 1000.0}) {
      qp::StagePoint far = random.feasible;
      for (std::size_t k = 0; k < far.stages.size(); ++k) {
        far.stages[k].x += s * random.direction.stages[k].x;
        far.stages[k].u += s * random.direction.stages[k].u;
      }
      EXPECT_LT(kkt_residual(random.qp, far).feasibility, 1e-14 * (100.0 + s)) << seed;
      EXPECT_NEAR(objective(random.qp, far), start + s * random.slope, 1e-9 * s)
          << seed << ": " << random.proof;
    }
  }
  EXPECT_EQ(kinds.size(), 3u);
}

TEST(InfeasibleQp, EveryKindOccurs) {
  std::map<std::string, int> kinds;
  for (int seed = 1; seed <= seeds; ++seed) ++kinds[infeasible_qp(seed).proof];
  EXPECT_EQ(kinds.size(), 4u);
  for (const auto& [proof, count] : kinds) EXPECT_GT(count, seeds / 8) << proof;
}

}  // namespace
}  // namespace saltus
