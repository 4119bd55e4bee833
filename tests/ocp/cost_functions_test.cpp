// Costs composed from formulas: values, derivatives and patterns.
#include "saltus/ocp/cost_functions.hpp"

#include <gtest/gtest.h>

#include <random>

#include "saltus/model/make_function.hpp"

namespace saltus {
namespace {

// Compares value and gradient with central differences at random points.
void expect_exact_derivatives(const Function& f, unsigned seed, double away_from_kinks = 0.0) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  VectorXd weights = VectorXd::Ones(f.outputs());
  for (double& w : weights) w = any(random);
  for (int trial = 0; trial < 5; ++trial) {
    VectorXd z(f.inputs());
    for (double& v : z) v = any(random);
    z[0] = std::abs(z[0]) + away_from_kinks;  // time
    const MatrixXd jacobian = f.dense_jacobian(z), hessian = f.dense_hessian(z, weights);
    const double h = 1e-5;  // truncation 1e-10, rounding 1e-11
    for (int i = 0; i < z.size(); ++i) {
      VectorXd above = z, below = z;
      above[i] += h;
      below[i] -= h;
      const VectorXd slope = (f(above) - f(below)) / (2.0 * h);
      EXPECT_LT((jacobian.col(i) - slope).cwiseAbs().maxCoeff(), 1e-8) << "seed " << seed;
      const VectorXd curvature =
          (f.dense_jacobian(above) - f.dense_jacobian(below)).transpose() * weights / (2.0 * h);
      EXPECT_LT((hessian.col(i) - curvature).cwiseAbs().maxCoeff(), 1e-8) << "seed " << seed;
    }
  }
}

const Function residual = make_function<2, 1, 0>([](const auto& t, const auto& x, const auto& u) {
  using S = std::decay_t<decltype(u[0] + x[0])>;
  return Vec<S, 2>{x[0] * x[1] + t, x[1] * x[1] * u[0]};
});

TEST(LeastSquares, SupportsFullWeightsAndMovingReferences) {
  Mat<double, 2, 2> weight;
  weight << 2.0, 0.5, 0.5, 1.0;
  const Reference moving({0.0, 5.0}, Mat<double, 2, 2>{{0.0, 3.0}, {1.0, -2.0}});
  const Function f = least_squares_cost(residual, weight, moving);
  expect_exact_derivatives(f, 1, 0.1);
  const Vec<double, 4> z{1.0, 0.3, -0.4, 0.7};
  Vec<double, 2> r = residual(z);
  r -= Vec<double, 2>{0.6, 0.4};
  EXPECT_NEAR(f(z)[0], 0.5 * r.dot(weight * r), 1e-14);
}

TEST(LeastSquares, GaussNewtonIsTheJacobianSquared) {
  const MatrixXd weight = Vec<double, 2>{2.0, 3.0}.asDiagonal();
  const Function f = least_squares_cost(residual, weight, {});
  const Vec<double, 4> z{0.2, 0.3, -0.4, 0.7};
  const MatrixXd J = residual.dense_jacobian(z);
  const MatrixXd given = f.dense_hessian(z, Vec<double, 1>{1.5}, Curvature::gauss_newton);
  EXPECT_LT((given - 1.5 * J.transpose() * weight * J).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(LeastSquares, ZeroWeightsRemoveRowsFromThePattern) {
  const MatrixXd weight = Vec<double, 2>{2.0, 0.0}.asDiagonal();
  const Function f = least_squares_cost(residual, weight, {});
  EXPECT_FALSE(f.jacobian_pattern().contains(0, 3));  // u enters the second row only
  EXPECT_TRUE(f.jacobian_pattern().contains(0, 1));
}

TEST(TimesLength, IsLinearInTheLength) {
  const Function cost = make_function<2, 1, 0>(
      [](const auto& t, const auto& x, const auto& u) { return t * x[0] * x[0] + u[0] * x[1]; });
  const Function f = times_length(cost);
  ASSERT_EQ(f.inputs(), 5);
  expect_exact_derivatives(f, 2);
  Vec<double, 5> z{0.5, 1.0, 2.0, 3.0, 0.25};
  EXPECT_NEAR(f(z)[0], 0.25 * (0.5 + 6.0), 1e-14);
}

TEST(TimesLength, ConstantStillDependsOnTheLength) {
  const Function f = times_length(
      make_function<1, 0, 0>([](const auto& t, const auto&) { return 0.0 * t + 3.0; }));
  expect_exact_derivatives(f, 3);
}

TEST(Stack, ConcatenatesOutputs) {
  const Function f = stack({residual, least_squares_cost(residual, MatrixXd::Identity(2, 2), {})});
  ASSERT_EQ(f.outputs(), 3);
  expect_exact_derivatives(f, 4);
}

TEST(ChangeCosts, AreSquaredDifferences) {
  const Function f = change_costs(Vec<double, 3>{2.0, 0.0, 5.0});
  expect_exact_derivatives(f, 5);
  Vec<double, 6> z;
  z << 1.0, 2.0, 3.0, 4.0, 9.0, 1.0;
  EXPECT_NEAR(f(z)[0], 9.0, 1e-14);
  EXPECT_NEAR(f(z)[1], 0.0, 1e-14);
  EXPECT_NEAR(f(z)[2], 10.0, 1e-14);
  EXPECT_EQ(f.jacobian_pattern().entries(), 4);  // a zero weight gives no entry
}

}  // namespace
}  // namespace saltus
