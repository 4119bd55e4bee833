// Tests the implicit midpoint rule: measured order, exact discrete derivatives, energy conservation
// and stability.
#include "saltus/integrators/runge_kutta.hpp"

#include "saltus/core/error.hpp"
#include "tests/integrators/support.hpp"

namespace saltus {
namespace {

using namespace test;

// Differences of functions of order one with the step of differences(): measured 1e-12 to 1e-11.
constexpr double difference_error = 1e-10;

class MidpointBothShapes : public ::testing::TestWithParam<InputShape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, MidpointBothShapes,
                         ::testing::Values(InputShape::constant, InputShape::linear),
                         [](const auto& param) {
                           return param.param == InputShape::constant ? "constant" : "linear";
                         });

TEST_P(MidpointBothShapes, HasSecondOrderInStateAndSensitivity) {
  const VectorXd w = coupled_point(GetParam());
  const auto reference = runge_kutta8({.steps = 60})->make(coupled_problem(GetParam()));
  const auto coarse = implicit_midpoint({.steps = 16})->make(coupled_problem(GetParam()));
  const auto fine = implicit_midpoint({.steps = 32})->make(coupled_problem(GetParam()));
  const VectorXd end = end_of(*reference, w);
  const MatrixXd slope = jacobian_of(*reference, w);
  const auto order = [](double coarse_error, double fine_error) {
    return std::log2(coarse_error / fine_error);
  };
  EXPECT_NEAR(order((end_of(*coarse, w) - end).norm(), (end_of(*fine, w) - end).norm()), 2.0, 0.1);
  EXPECT_NEAR(
      order((jacobian_of(*coarse, w) - slope).norm(), (jacobian_of(*fine, w) - slope).norm()), 2.0,
      0.1);
}

TEST_P(MidpointBothShapes, DerivativesOfFirstAndSecondOrderAreExact) {
  const VectorXd w = coupled_point(GetParam());
  const VectorXd weights = (VectorXd(5) << 0.7, -1.3, 0.4, 0.9, -0.6).finished();
  for (const int steps : {1, 3}) {
    const auto integrator = implicit_midpoint({.steps = steps})->make(coupled_problem(GetParam()));
    expect_jacobian_matches(*integrator, w, difference_error);
    expect_hessian_matches(*integrator, w, weights, difference_error);
  }
}

TEST_P(MidpointBothShapes, GaussNewtonIsExactForAffineDynamics) {
  const auto integrator =
      implicit_midpoint({.steps = 2})->make(affine_problem(GetParam(), false, false));
  const VectorXd w = affine_point(GetParam(), 0.4);
  const VectorXd weights = (VectorXd(5) << 0.7, -1.3, 0.4, 0.9, -0.6).finished();
  const MatrixXd exact = hessian_of(*integrator, w, weights);
  EXPECT_GT(exact.norm(), 0.1);
  EXPECT_LE((exact - hessian_of(*integrator, w, weights, Curvature::gauss_newton)).norm(), 1e-14);
}

TEST_P(MidpointBothShapes, IsSelfInverse) {
  const auto integrator = implicit_midpoint({.steps = 2})->make(coupled_problem(GetParam()));
  const VectorXd w = coupled_point(GetParam());
  const VectorXd back = way_back(*integrator, w, end_of(*integrator, w));
  constexpr double rounding = 1e-14;
  EXPECT_LE((end_of(*integrator, back).head(3) - w.head(3)).cwiseAbs().maxCoeff(), rounding);
}

IntervalProblem autonomous(Function dynamics, int nx) {
  IntervalProblem problem;
  problem.arguments = {nx, 0, 0};
  problem.dynamics = std::move(dynamics);
  return problem;
}

// 500 periods of an oscillator with 20 steps each. The rule conserves the energy; the classical
// scheme of order 4 loses h^6 / 72 of it in each step.
TEST(ImplicitMidpoint, KeepsTheEnergyOfAnOscillator) {
  const IntervalProblem problem = autonomous(make_function<2, 0, 0>([](const auto&, const auto& x) {
                                               return std::decay_t<decltype(x)>{x[1], -x[0]};
                                             }),
                                             2);
  const double time = 500.0 * 2.0 * 3.14159;
  const VectorXd w = (VectorXd(4) << 1.0, 0.0, 0.0, time).finished();
  const auto energy = [&](const IntegratorChoice& scheme) {
    return end_of(*scheme->make(problem), w).head(2).squaredNorm();
  };
  EXPECT_NEAR(energy(implicit_midpoint({.steps = 10000})), 1.0, 1e-11);
  EXPECT_NEAR(energy(runge_kutta4({.steps = 10000})), 0.875, 0.01);
}

// A time constant of a microsecond in steps of 0.1 s: |(1 - a) / (1 + a)| with a = 5e4.
TEST(ImplicitMidpoint, IsStableForAnyStep) {
  const IntervalProblem problem =
      autonomous(make_function<1, 0, 0>([](const auto&, const auto& x) { return -1e6 * x[0]; }), 1);
  const VectorXd w = (VectorXd(3) << 1.0, 0.0, 1.0).finished();
  const double end = end_of(*implicit_midpoint({.steps = 10})->make(problem), w)[0];
  EXPECT_NEAR(end, std::pow((1.0 - 5e4) / (1.0 + 5e4), 10), 1e-9);
  EXPECT_GT(std::abs(end_of(*runge_kutta4({.steps = 10})->make(problem), w)[0]), 1e100);
}

TEST(ImplicitMidpoint, ReportsFailuresAsStatus) {
  expect_undefined(*implicit_midpoint());
  const VectorXd w = (VectorXd(3) << -1.0, 0.0, 1.0).finished();
  VectorXd end(1);
  // X = -1 + (X^2 + 5) / 2 has no solution.
  const auto parabola = implicit_midpoint()->make(autonomous(
      make_function<1, 0, 0>([](const auto&, const auto& x) { return x[0] * x[0] + 5.0; }), 1));
  EXPECT_EQ(parabola->value(w.data(), end.data()), IntegrationStatus::step_too_small);
  EXPECT_THROW(implicit_midpoint({.steps = 0}), DefinitionError);
}

TEST(ImplicitMidpoint, LengthZeroIsTheIdentity) {
  const auto integrator = implicit_midpoint()->make(coupled_problem(InputShape::constant));
  VectorXd w = coupled_point(InputShape::constant);
  w[integrator->arguments().h()] = 0.0;
  EXPECT_EQ(end_of(*integrator, w).head(3), w.head(3));
  EXPECT_EQ(jacobian_of(*integrator, w).topLeftCorner(3, 3), MatrixXd::Identity(3, 3));
}

}  // namespace
}  // namespace saltus
