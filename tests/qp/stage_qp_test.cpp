// Objective and residual of stage programs. The residual is zero at known optima, each error
// appears in its part, and nothing allocates.
#include "saltus/qp/stage_qp.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/support/count_allocations.hpp"

namespace saltus {
namespace {

constexpr double rounding = 1e-14;  // a few operations on numbers of order one

// x_1 = x_0 + u, x_0 = 1, cost 1/2 x_1^2 + 1/2 u^2. The unconstrained optimum is u = -1/2. A bound
// or a row -1/4 <= u gives x_1 = costate = 3/4 and multiplier -1/2.
class OneStep : public ::testing::Test {
 protected:
  OneStep() : qp({{1, 1, {{1, 1, false}}}, {1, 0, {}}}) {
    qp.start[0] = 1.0;
    qp.stages[0].A(0, 0) = qp.stages[0].B(0, 0) = 1.0;
    qp.stages[0].R(0, 0) = qp.stages[1].Q(0, 0) = 1.0;
    point = qp::StagePoint(qp);
  }
  void input_at(double u, double costate) {
    point.stages[0].x[0] = 1.0;
    point.stages[0].u[0] = u;
    point.stages[1].x[0] = 1.0 + u;
    point.stages[0].costate[0] = costate;
  }
  qp::RowGroup& row() { return qp.stages[0].groups[0]; }
  void row_at_least(double lower) {
    row().rows = 1;
    row().columns = {1};
    row().M(0, 0) = 1.0;
    row().lower[0] = lower;
  }
  void soften(double l1, double l2) {
    row().soft = true;
    row().l1[0] = l1;
    row().l2[0] = l2;
  }
  double& multiplier() { return point.stages[0].group[0][0]; }
  qp::StageQp::Residual residual() const { return kkt_residual(qp, point); }

  qp::StageQp qp;
  qp::StagePoint point;
};

TEST_F(OneStep, ResidualVanishesAtTheFreeOptimum) {
  input_at(-0.5, 0.5);
  qp.stages[0].constant = 3.0;
  EXPECT_LT(residual().largest(), rounding);
  EXPECT_NEAR(objective(qp, point), 3.25, rounding);
}

TEST_F(OneStep, EachErrorShowsInItsComponent) {
  input_at(-0.5, 0.5);
  point.stages[0].costate[0] = 0.75;
  EXPECT_NEAR(residual().stationarity, 0.25, rounding);
  EXPECT_LT(residual().feasibility, rounding);
  input_at(-0.5, 0.5);
  point.stages[1].x[0] = 0.75;
  EXPECT_NEAR(residual().feasibility, 0.25, rounding);
  input_at(-0.5, 0.5);
  point.stages[0].x[0] = 0.875;
  EXPECT_NEAR(residual().feasibility, 0.125, rounding);
  input_at(-0.5, 0.5);
  point.stages[0].u_bound[0] = -0.5;  // there is no bound
  EXPECT_NEAR(residual().complementarity, 0.5, rounding);
  qp.stages[0].u_lower[0] = -0.75;  // the bound is 1/4 away
  EXPECT_NEAR(residual().complementarity, 0.125, rounding);
}

TEST_F(OneStep, ResidualVanishesWithAnActiveBound) {
  input_at(-0.25, 0.75);
  qp.stages[0].u_lower[0] = -0.25;
  point.stages[0].u_bound[0] = -0.5;
  EXPECT_LT(residual().largest(), rounding);
  qp.stages[0].u_lower[0] = -0.125;
  EXPECT_NEAR(residual().feasibility, 0.125, rounding);
}

TEST_F(OneStep, ResidualVanishesWithAnActiveRow) {
  input_at(-0.25, 0.75);
  row_at_least(-0.25);
  multiplier() = -0.5;
  EXPECT_LT(residual().largest(), rounding);
  multiplier() = 0.5;  // a side that does not exist
  EXPECT_NEAR(residual().complementarity, 0.5, rounding);
  row().upper[0] = row().lower[0];  // an equality allows either sign
  EXPECT_LT(residual().complementarity, rounding);
  EXPECT_NEAR(residual().stationarity, 1.0, rounding);
}

TEST_F(OneStep, BoundsOfAFixedStartAreNotRead) {
  input_at(-0.5, 0.5);
  qp.stages[0].x_lower[0] = 2.0;
  EXPECT_LT(residual().largest(), rounding);
  qp.fixed_start = false;
  EXPECT_NEAR(residual().feasibility, 1.0, rounding);
  EXPECT_NEAR(residual().stationarity, 0.5, rounding);  // the costate acts on x_0
}

TEST_F(OneStep, CheapSoftRowIsViolated) {
  row_at_least(-0.25);
  soften(0.3, 0.0);
  input_at(-0.35, 0.65);  // 2 u + 1 = l1
  multiplier() = -0.3;
  EXPECT_LT(residual().largest(), rounding);
  EXPECT_NEAR(objective(qp, point), 0.5 * (0.35 * 0.35 + 0.65 * 0.65) + 0.03, rounding);
  multiplier() = -0.2;  // a violated side is penalised in full
  EXPECT_NEAR(residual().complementarity, 0.1 * 0.1, rounding);
  multiplier() = -0.4;  // and not more
  EXPECT_NEAR(residual().stationarity, 0.1, rounding);
}

TEST_F(OneStep, ResidualVanishesWithAQuadraticPenalty) {
  row_at_least(-0.25);
  soften(0.3, 1.0);
  const double u = -0.95 / 3.0;  // 2 u + 1 = l1 + l2 (-1/4 - u)
  input_at(u, 1.0 + u);
  multiplier() = -(2.0 * u + 1.0);
  EXPECT_LT(residual().largest(), rounding);
  // A multiplier too large by 0.06 would be correct if the row were violated by 0.06 more.
  const double right = multiplier();
  multiplier() -= 0.06;
  EXPECT_NEAR(residual().complementarity, 0.06 * (0.06 - right), rounding);
}

TEST_F(OneStep, ExpensiveSoftRowHoldsExactly) {
  row_at_least(-0.25);
  soften(1.0, 0.0);
  input_at(-0.25, 0.75);
  multiplier() = -0.5;
  EXPECT_LT(residual().largest(), rounding);
  soften(0.4, 0.0);  // a violation would now decrease the cost
  EXPECT_NEAR(residual().stationarity, 0.1, rounding);
}

TEST_F(OneStep, NanIsDetected) {
  input_at(-0.5, 0.5);
  point.stages[0].u[0] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(std::isinf(residual().stationarity));
  EXPECT_TRUE(std::isinf(residual().feasibility));
}

TEST_F(OneStep, SizesBelowTheCapacityAreRespected) {
  input_at(-0.5, 0.5);
  qp::StageQp roomy({{3, 2, {{4, 3, false}, {2, 2, true}}}, {2, 1, {}}});
  qp::StagePoint there(roomy);
  for (qp::Stage& s : roomy.stages) {
    for (MatrixXd* M : {&s.A, &s.B, &s.Q, &s.S, &s.R}) M->setConstant(7.0);
    for (VectorXd* v : {&s.q, &s.r, &s.b}) v->setConstant(7.0);
    s.nx = 1;
    s.nu = &s == &roomy.stages[0] ? 1 : 0;
    s.Q(0, 0) = s.S(0, 0) = s.q[0] = s.r[0] = 0.0;
  }
  roomy.stages[0].b[0] = 0.0;
  roomy.start[0] = roomy.stages[0].A(0, 0) = roomy.stages[0].B(0, 0) = 1.0;
  roomy.stages[0].R(0, 0) = roomy.stages[1].Q(0, 0) = 1.0;
  for (int k = 0; k < 2; ++k) there.stages[k].x[0] = point.stages[k].x[0];
  there.stages[0].u[0] = point.stages[0].u[0];
  there.stages[0].costate[0] = point.stages[0].costate[0];
  EXPECT_LT(kkt_residual(roomy, there).largest(), rounding);
  EXPECT_EQ(objective(roomy, there), objective(qp, point));
}

TEST_F(OneStep, DoesNotAllocate) {
  row_at_least(-0.25);
  soften(0.3, 1.0);
  const testing::AllocationCount count;
  double sum = objective(qp, point) + kkt_residual(qp, point).largest();
  EXPECT_EQ(count.made(), 0);
  EXPECT_TRUE(std::isfinite(sum));
}

}  // namespace
}  // namespace saltus
