// Objective and residual of sparse programs at known optima, without allocation.
#include "saltus/qp/sparse_qp.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/count_allocations.hpp"

namespace saltus {
namespace {

constexpr double rounding = 1e-14;  // a few operations on numbers of order one

// min 1/2 (2 a^2 + 2 a b + 2 b^2) - 3 a with a + b <= 1 and a <= 1/2: a = 1/2, b = -1/4, z_a = 9/4.
class TwoVariables : public ::testing::Test {
 protected:
  TwoVariables()
      : qp(SparsityPattern::from_pairs(2, 2, {{0, 0}, {1, 0}, {1, 1}}),
           SparsityPattern::dense(1, 2)) {
    qp.hessian << 2.0, 1.0, 2.0;
    qp.gradient << -3.0, 0.0;
    qp.rows << 1.0, 1.0;
    qp.row_upper[0] = 1.0;
    qp.upper[0] = 0.5;
    point = {Vec<double, 2>{0.5, -0.25}, VectorXd::Zero(1), Vec<double, 2>{2.25, 0.0}};
  }
  qp::SparseQp qp;
  PrimalDualPoint point;
};

TEST_F(TwoVariables, ResidualsVanishAtTheOptimum) {
  EXPECT_LT(kkt_residual(qp, point).largest(), rounding);
  qp.constant = 2.0;
  EXPECT_NEAR(objective(qp, point.w), 2.0 + 0.25 - 0.125 + 0.0625 - 1.5, rounding);
}

TEST_F(TwoVariables, EachErrorShowsInItsComponent) {
  point.z[0] = 2.0;
  EXPECT_NEAR(kkt_residual(qp, point).stationarity, 0.25, rounding);
  point.z[0] = 2.25;
  qp.row_upper[0] = 0.0;
  EXPECT_NEAR(kkt_residual(qp, point).feasibility, 0.25, rounding);
  qp.row_upper[0] = 1.0;
  point.lambda[0] = 0.5;  // the row has a slack of 3/4
  EXPECT_NEAR(kkt_residual(qp, point).complementarity, 0.375, rounding);
  point.lambda[0] = -0.5;  // there is no lower side
  EXPECT_NEAR(kkt_residual(qp, point).complementarity, 0.5, rounding);
}

TEST_F(TwoVariables, MultipliersOfEqualitiesAreFree) {
  qp.lower[0] = qp.upper[0];
  qp.row_lower[0] = qp.row_upper[0] = 0.25;
  EXPECT_LT(kkt_residual(qp, point).largest(), rounding);
  qp.gradient[0] = 1.0;
  point.z[0] = -1.75;
  EXPECT_LT(kkt_residual(qp, point).largest(), rounding);
}

TEST(SparseQpResidual, CoversLargePrograms) {
  constexpr int n = 1000;  // more than the function processes at once
  std::vector<std::pair<int, int>> diagonal, chain;
  for (int i = 0; i < n; ++i) diagonal.push_back({i, i});
  for (int i = 0; i + 1 < n; ++i) {
    chain.push_back({i, i});
    chain.push_back({i, i + 1});
  }
  qp::SparseQp qp(SparsityPattern::from_pairs(n, n, diagonal),
                  SparsityPattern::from_pairs(n - 1, n, chain));
  qp.hessian.setOnes();
  qp.rows.setOnes();
  PrimalDualPoint point{VectorXd::Zero(n), VectorXd::Zero(n - 1), VectorXd::Zero(n)};
  EXPECT_EQ(kkt_residual(qp, point).largest(), 0.0);
  for (const int i : {0, 255, 256, 999}) {
    qp.gradient.setZero();
    qp.gradient[i] = 0.5;
    EXPECT_EQ(kkt_residual(qp, point).stationarity, 0.5) << i;
    point.w = -qp.gradient;
    EXPECT_EQ(kkt_residual(qp, point).stationarity, 0.0) << i;
    point.w.setZero();
  }
  const testing::AllocationCount count;
  const double sum = kkt_residual(qp, point).largest() + objective(qp, point.w);
  EXPECT_EQ(count.made(), 0);
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace saltus
