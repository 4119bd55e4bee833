// Tests the judge itself on plans with known faults and on plans without faults.
#include <gtest/gtest.h>

#include <cmath>

#include "tests/corpus/formulas.hpp"
#include "tests/corpus/outside.hpp"
#include "tests/corpus/stationarity.hpp"

namespace saltus::corpus {
namespace {

constexpr int intervals = 10;

// Least effort from rest to rest over 1 m in 1 s with piecewise constant u. By symmetry and
// stationarity, u_k = slope (0.5 - t_k), where t_k is the middle of the interval.
std::vector<PlanPiece> least_effort(double slope_change = 0.0) {
  const double h = 1.0 / intervals;
  double moment = 0.0;
  for (int k = 0; k < intervals; ++k) {
    const double s = 0.5 - (k + 0.5) * h;
    moment += s * s * h;
  }
  std::vector<PlanPiece> plan;
  VectorXd x = VectorXd::Zero(2);
  for (int k = 0; k < intervals; ++k) {
    const double s = 0.5 - (k + 0.5) * h;
    const double u = s / moment + slope_change * (k % 2 == 0 ? 1.0 : -1.0);
    const VectorXd end{{x[0] + x[1] * h + 0.5 * u * h * h, x[1] + u * h}};
    plan.push_back({0, k * h, h, x, end, VectorXd::Constant(1, u), VectorXd::Constant(1, u)});
    x = end;
  }
  return plan;
}

std::vector<OutsidePhase> problem() {
  Twin<2, 1> twin("move", DoubleIntegrator{}, exactly(1.0));
  twin.minimise("effort", Effort{1.0}).reach("there", WholeState{}, {exactly(1.0), exactly(0.0)});
  return {twin.outside};
}

TEST(Judge, AcceptsTheOptimum) {
  const OutsideCheck check = check_outside(problem(), least_effort());
  EXPECT_TRUE(check.simulated);
  EXPECT_FALSE(check.path.is_broken());
  EXPECT_FALSE(check.end.is_broken()) << check.end.what << ' ' << check.end.amount;
  EXPECT_FALSE(check.open_loop_end.is_broken());
  EXPECT_LT(check.defect.relative(), 1e-6);
  EXPECT_LT(stationarity(problem(), least_effort()).residual, 1e-9);
}

TEST(Judge, FindsAPlanThatIsNotAKktPoint) {
  // The perturbation alternates, so that the end errors barely change and the effort increases.
  EXPECT_GT(stationarity(problem(), least_effort(1.0)).residual, 1e-2);
}

TEST(Judge, FindsAMissedEnd) {
  std::vector<PlanPiece> plan = least_effort();
  plan.back().end_state[0] += 1e-5;
  EXPECT_TRUE(check_outside(problem(), plan).end.is_broken());
  plan = least_effort();
  plan[3].first_input[0] += 1e-3;
  plan[3].last_input[0] += 1e-3;
  EXPECT_TRUE(check_outside(problem(), plan).open_loop_end.is_broken());
}

TEST(Judge, FindsAWrongJump) {
  std::vector<PlanPiece> plan = least_effort();
  plan[4].state[1] += 1e-2;
  EXPECT_TRUE(check_outside(problem(), plan).defect.is_broken());
}

TEST(Judge, FindsAViolationBetweenTheNodes) {
  // The speed is largest at 0.5 s. The plan crosses a narrow wall between two nodes at 0.4 m.
  Twin<2, 1> twin("move", DoubleIntegrator{}, exactly(1.0));
  twin.keep(
      "wall",
      [](const auto&, const auto& x) {
        using std::exp;
        const auto s = (x[0] - 0.4) / 1e-3;
        return std::decay_t<decltype(x[0])>(exp(-s * s));
      },
      at_most(0.5));
  twin.outside.max_step = 1e-4;
  const OutsideCheck check = check_outside({twin.outside}, least_effort());
  EXPECT_NEAR(check.path.amount, 0.5, 1e-6);
}

TEST(Judge, AcceptsAnInputAtItsBound) {
  // x' = u, |u| <= 1, min -x(1): active bounds balance the gradient. Where u is inside its bounds,
  // the gradient is not balanced.
  Twin<1, 1> twin("run", Integrators{}, exactly(1.0));
  twin.bound_input(0, between(-1.0, 1.0)).minimise_at_end("way", [](const auto&, const auto& x) {
    return std::decay_t<decltype(x[0])>(-x[0]);
  });
  const auto plan = [](double u) {
    return std::vector<PlanPiece>{{0, 0.0, 1.0, VectorXd::Zero(1), VectorXd::Constant(1, u),
                                   VectorXd::Constant(1, u), VectorXd::Constant(1, u)}};
  };
  EXPECT_LT(stationarity({twin.outside}, plan(1.0)).residual, 1e-12);
  EXPECT_GT(stationarity({twin.outside}, plan(0.5)).residual, 0.1);
  EXPECT_GT(stationarity({twin.outside}, plan(-1.0)).residual, 0.1);
}

TEST(NonNegativeLeastSquares, KeepsSigns) {
  const MatrixXd a = MatrixXd::Identity(2, 2);
  const VectorXd x = non_negative_least_squares(a, VectorXd{{-1.0, 2.0}}, {false, false});
  EXPECT_DOUBLE_EQ(x[0], 0.0);
  EXPECT_DOUBLE_EQ(x[1], 2.0);
  EXPECT_DOUBLE_EQ(non_negative_least_squares(a, VectorXd{{-1.0, 2.0}}, {true, false})[0], -1.0);
}

}  // namespace
}  // namespace saltus::corpus
