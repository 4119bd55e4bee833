// The KKT residual is zero at an optimum, and each part detects one kind of error.
#include "saltus/solver/optimum_check.hpp"

#include <gtest/gtest.h>

#include "tests/solver/small_programs.hpp"

namespace saltus {
namespace {

// The optimum of Rosenbrock's function with a <= 1/2 is (1/2, 1/4), with multiplier 1.
class AtTheOptimum : public testing::Test {
 protected:
  AtTheOptimum() { program.upper_[0] = 0.5; }
  testing_support::Rosenbrock program;
  NlpPoint point{Vec<double, 2>{0.5, 0.25}, VectorXd::Zero(1), Vec<double, 2>{1.0, 0.0}};
};

TEST_F(AtTheOptimum, AllResidualsVanish) {
  const KktCheck::Residual r = kkt_residual(program, point);
  EXPECT_LT(r.scaled(), 1e-14);
  EXPECT_EQ(r.worst_row, -1);
  EXPECT_EQ(r.worst_variable, -1);
}

TEST_F(AtTheOptimum, WrongMultiplierShowsInStationarity) {
  point.z[0] = 1.25;
  EXPECT_NEAR(kkt_residual(program, point).stationarity, 0.25, 1e-14);
  point.z[0] = 1.0;
  point.lambda[0] = 0.5;
  EXPECT_NEAR(kkt_residual(program, point).stationarity, 0.5, 1e-14);
}

TEST_F(AtTheOptimum, MultiplierWithoutABoundShowsInComplementarity) {
  point.lambda[0] = 0.5;  // the row is free
  EXPECT_NEAR(kkt_residual(program, point).complementarity, 0.5, 1e-14);
}

TEST_F(AtTheOptimum, MultiplierOfAnInactiveBoundShowsInComplementarity) {
  program.row_upper_[0] = 2.75;  // off by 2
  point.lambda[0] = 0.5;
  EXPECT_NEAR(kkt_residual(program, point).complementarity, 1.0, 1e-14);
}

TEST_F(AtTheOptimum, WrongSignIsDetected) {
  program.lower_[0] = -1.5;
  point.z[0] = -1.0;  // the sign of the lower side
  EXPECT_NEAR(kkt_residual(program, point).complementarity, 2.0, 1e-14);
}

TEST_F(AtTheOptimum, ReportsViolations) {
  point.w[0] = 0.6;
  KktCheck::Residual r = kkt_residual(program, point);
  EXPECT_NEAR(r.feasibility, 0.1, 1e-14);
  EXPECT_EQ(r.worst_variable, 0);
  program.row_upper_[0] = 0.5;
  r = kkt_residual(program, point);
  EXPECT_NEAR(r.feasibility, 0.35, 1e-14);
  EXPECT_EQ(r.worst_row, 0);
  EXPECT_EQ(r.worst_variable, -1);
}

TEST_F(AtTheOptimum, ProgramsThatCannotBeEvaluatedHaveAnInfiniteResidual) {
  program.fails = true;
  EXPECT_TRUE(std::isinf(kkt_residual(program, point).scaled()));
}

TEST_F(AtTheOptimum, DetectsNanAndMissingEntries) {
  KktCheck check(program);
  EXPECT_LT(check(program, point).scaled(), 1e-14);
  NlpPoint other = point;
  other.z[1] = std::nan("");
  EXPECT_TRUE(std::isinf(check(program, other).scaled()));
  other = point;
  other.lambda.resize(0);
  EXPECT_TRUE(std::isinf(check(program, other).scaled()));
  EXPECT_LT(check(program, point).scaled(), 1e-14);  // no residual remains
}

// The multiplier of a fixed variable may have any size. It does not relax the check of other
// variables.
TEST_F(AtTheOptimum, MultiplierOfAFixedVariableDoesNotScale) {
  program.lower_[0] = 0.5;
  point.z[0] = 1e12;
  point.w[1] = 0.5;
  const KktCheck::Residual r = kkt_residual(program, point);
  EXPECT_EQ(r.multiplier_scale, 1.0);
  EXPECT_NEAR(r.scaled(), 50.0, 1e-12);
}

}  // namespace
}  // namespace saltus
