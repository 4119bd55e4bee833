// Fixed-step Runge-Kutta: measured orders, exact discrete derivatives, limits of the definition.
#include "saltus/integrators/runge_kutta.hpp"

#include "saltus/core/error.hpp"
#include "tests/integrators/support.hpp"

namespace saltus {
namespace {

using namespace test;

// Differences of functions of order one with the step of differences(): measured 1e-12 to 1e-11.
constexpr double difference_error = 1e-10;

class RungeKuttaBothShapes : public testing::TestWithParam<InputShape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, RungeKuttaBothShapes,
                         testing::Values(InputShape::constant, InputShape::linear),
                         [](const auto& param) {
                           return param.param == InputShape::constant ? "constant" : "linear";
                         });

// log2 of the error ratio when the number of steps doubles.
double measured_order(InputShape shape, bool eighth_order, int steps, bool of_sensitivity) {
  const VectorXd w = coupled_point(shape);
  const auto solve = [&](int n) -> MatrixXd {
    const auto scheme = eighth_order ? runge_kutta8({.steps = n}) : runge_kutta4({.steps = n});
    const auto integrator = scheme->make(coupled_problem(shape));
    if (of_sensitivity) return jacobian_of(*integrator, w);
    return end_of(*integrator, w);
  };
  const auto reference = runge_kutta8({.steps = 60})->make(coupled_problem(shape));
  const MatrixXd exact =
      of_sensitivity ? jacobian_of(*reference, w) : MatrixXd(end_of(*reference, w));
  const double coarse = (solve(steps) - exact).norm(), fine = (solve(2 * steps) - exact).norm();
  return std::log2(coarse / fine);
}

TEST_P(RungeKuttaBothShapes, HasFourthOrderInStateAndSensitivity) {
  const double state = measured_order(GetParam(), false, 8, false);
  const double sensitivity = measured_order(GetParam(), false, 8, true);
  RecordProperty("order", std::to_string(state) + " " + std::to_string(sensitivity));
  EXPECT_NEAR(state, 4.0, 0.25);
  EXPECT_NEAR(sensitivity, 4.0, 0.25);
}

TEST_P(RungeKuttaBothShapes, HasEighthOrderInStateAndSensitivity) {
  VectorXd w = coupled_point(GetParam());
  const double state = measured_order(GetParam(), true, 2, false);
  const double sensitivity = measured_order(GetParam(), true, 2, true);
  RecordProperty("order", std::to_string(state) + " " + std::to_string(sensitivity));
  EXPECT_NEAR(state, 8.0, 0.6);
  EXPECT_NEAR(sensitivity, 8.0, 0.6);
}

TEST_P(RungeKuttaBothShapes, DerivativesOfFirstAndSecondOrderAreExact) {
  const VectorXd w = coupled_point(GetParam());
  const VectorXd weights = (VectorXd(5) << 0.7, -1.3, 0.4, 0.9, -0.6).finished();
  for (const auto& scheme : {runge_kutta4(), runge_kutta4({.steps = 3}), runge_kutta8()}) {
    SCOPED_TRACE(scheme->name());
    const auto integrator = scheme->make(coupled_problem(GetParam()));
    expect_jacobian_matches(*integrator, w, difference_error);
    expect_hessian_matches(*integrator, w, weights, difference_error);
  }
}

TEST_P(RungeKuttaBothShapes, DerivativesWithoutTimeAndParametersAreExact) {
  IntervalProblem problem = coupled_problem(GetParam());
  problem.differentiate_parameter.clear();
  problem.differentiate_time = false;
  const auto integrator = runge_kutta4({.steps = 2})->make(problem);
  const VectorXd w = coupled_point(GetParam());
  expect_jacobian_matches(*integrator, w, difference_error);
  expect_hessian_matches(*integrator, w, VectorXd::Ones(5), difference_error);
}

TEST_P(RungeKuttaBothShapes, ValueAndJacobianGiveTheSameState) {
  const auto integrator = runge_kutta4({.steps = 3})->make(coupled_problem(GetParam()));
  const VectorXd w = coupled_point(GetParam());
  VectorXd end(5);
  MatrixXd derivative(5, w.size());
  ASSERT_EQ(integrator->jacobian(w.data(), end.data(), derivative), IntegrationStatus::success);
  // The operations are the same, but the compiler may fuse multiplications and additions
  // differently.
  constexpr double rounding = 1e-14;
  EXPECT_TRUE(end.isApprox(end_of(*integrator, w), rounding));
}

TEST_P(RungeKuttaBothShapes, IsReversible) {
  const auto integrator = runge_kutta8({.steps = 40})->make(coupled_problem(GetParam()));
  const VectorXd w = coupled_point(GetParam());
  const VectorXd end = end_of(*integrator, w);
  const VectorXd start = end_of(*integrator, way_back(*integrator, w, end));
  EXPECT_LE((start.head(3) - w.head(3)).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_LE((start.tail(2) + end.tail(2)).cwiseAbs().maxCoeff(), 1e-13);
}

// A cost of squares: its Gauss-Newton matrix is that of the residuals along the sensitivities.
TEST(RungeKutta, GaussNewtonDropsTheCurvatureOfTheDynamics) {
  const InputShape shape = InputShape::constant;
  IntervalProblem problem = coupled_problem(shape);
  problem.differentiate_time = false;
  problem.running_cost = {};
  const auto integrator = runge_kutta4()->make(problem);
  const MatrixXd none =
      hessian_of(*integrator, coupled_point(shape), VectorXd::Ones(3), Curvature::gauss_newton);
  EXPECT_EQ(none.cwiseAbs().maxCoeff(), 0.0);
}

// Affine dynamics have no curvature, so Gauss-Newton is exact.
TEST_P(RungeKuttaBothShapes, GaussNewtonIsExactForAffineDynamics) {
  const auto integrator =
      runge_kutta4({.steps = 2})->make(affine_problem(GetParam(), false, false));
  const VectorXd w = affine_point(GetParam(), 0.4);
  const VectorXd weights = (VectorXd(5) << 0.7, -1.3, 0.4, 0.9, -0.6).finished();
  const MatrixXd exact = hessian_of(*integrator, w, weights);
  const MatrixXd approximate = hessian_of(*integrator, w, weights, Curvature::gauss_newton);
  EXPECT_GT(exact.norm(), 0.1);
  EXPECT_LE((exact - approximate).norm(), 1e-15);
}

TEST(RungeKutta, LengthZeroIsTheIdentity) {
  for (const auto shape : {InputShape::constant, InputShape::linear}) {
    const auto integrator = runge_kutta4()->make(coupled_problem(shape));
    VectorXd w = coupled_point(shape);
    const IntervalArguments index = integrator->arguments();
    w[index.h()] = 0.0;
    const VectorXd end = end_of(*integrator, w);
    EXPECT_EQ(end.head(3), w.head(3));
    EXPECT_EQ(end.tail(2).norm(), 0.0);
    const MatrixXd derivative = jacobian_of(*integrator, w);
    VectorXd z(9);
    z << w[index.t0()], w.head(5), w.segment(index.p(), 3);
    if (shape == InputShape::constant) {
      VectorXd rate(5);
      rate << integrator->problem().dynamics(z), integrator->problem().running_cost(z);
      EXPECT_LE((derivative.col(index.h()) - rate).norm(), 1e-15);
    }
    EXPECT_EQ(derivative.topLeftCorner(3, 3), MatrixXd::Identity(3, 3));
  }
}

TEST(RungeKutta, ReportsNonFiniteRatesAsStatus) {
  for (const auto& scheme : {runge_kutta4(), runge_kutta8()}) expect_undefined(*scheme);
}

TEST(RungeKutta, ChecksDefinitions) {
  EXPECT_THROW(runge_kutta4({.steps = 0}), DefinitionError);
  ButcherTableau implicit = classical_runge_kutta();
  implicit.a(0, 0) = 0.1;
  EXPECT_THROW(runge_kutta(implicit), DefinitionError);
  IntervalProblem problem = coupled_problem(InputShape::constant);
  problem.arguments.nx = 2;
  EXPECT_THROW(runge_kutta4()->make(problem), DefinitionError);
}

TEST(RungeKutta, ChecksEachCoefficientOfATableau) {
  const ButcherTableau good = classical_runge_kutta();
  EXPECT_NO_THROW(runge_kutta(good));
  constexpr double off = 1e-9;  // far above rounding
  for (int i = 0; i < good.stages(); ++i) {
    ButcherTableau tableau = good;
    tableau.c[i] += off;
    EXPECT_THROW(runge_kutta(tableau), DefinitionError) << i;
    tableau = good;
    tableau.b[i] -= off;
    EXPECT_THROW(runge_kutta(tableau), DefinitionError) << i;
    for (int j = 0; j < good.stages(); ++j) {
      tableau = good;
      tableau.a(i, j) += off;
      EXPECT_THROW(runge_kutta(tableau), DefinitionError) << i << " " << j;
    }
  }
}

}  // namespace
}  // namespace saltus
