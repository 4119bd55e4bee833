// Tests the exact zero-order hold: closed forms, agreement with a high-order scheme, derivatives,
// and refused problems.
#include "saltus/integrators/zero_order_hold.hpp"

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "tests/integrators/support.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

using namespace test;

class ZeroOrderHoldBothShapes : public testing::TestWithParam<InputShape> {};
INSTANTIATE_TEST_SUITE_P(Shapes, ZeroOrderHoldBothShapes,
                         testing::Values(InputShape::constant, InputShape::linear),
                         [](const auto& param) {
                           return param.param == InputShape::constant ? "constant" : "linear";
                         });

TEST_P(ZeroOrderHoldBothShapes, AgreesWithOrderEight) {
  const IntervalProblem problem = affine_problem(GetParam(), true, true);
  const auto exact = zero_order_hold()->make(problem);
  const auto reference = runge_kutta8({.steps = 100})->make(problem);
  for (const double h : {0.01, 0.3, 2.0, -0.5, 0.0}) {
    SCOPED_TRACE(h);
    const VectorXd w = affine_point(GetParam(), h);
    // Rounding error of a hundred steps of the reference.
    EXPECT_LE((end_of(*exact, w) - end_of(*reference, w)).cwiseAbs().maxCoeff(), 1e-13);
    EXPECT_LE((jacobian_of(*exact, w) - jacobian_of(*reference, w)).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST_P(ZeroOrderHoldBothShapes, SecondDerivativesAgreeWithOrderEight) {
  const VectorXd weights = (VectorXd(5) << 0.7, -1.3, 0.4, 0.9, -0.6).finished();
  for (const bool time : {false, true}) {
    const IntervalProblem problem = affine_problem(GetParam(), false, time);
    const auto exact = zero_order_hold()->make(problem);
    const auto reference = runge_kutta8({.steps = 60})->make(problem);
    for (const double h : {0.02, 0.8, 0.0}) {
      const VectorXd w = affine_point(GetParam(), h);
      EXPECT_LE((hessian_of(*exact, w, weights) - hessian_of(*reference, w, weights))
                    .cwiseAbs()
                    .maxCoeff(),
                1e-12);
    }
    expect_jacobian_matches(*exact, affine_point(GetParam(), 0.6), 1e-10);
    expect_hessian_matches(*exact, affine_point(GetParam(), 0.6), weights, 1e-10);
  }
  EXPECT_FALSE(zero_order_hold()->make(affine_problem(GetParam(), true, false))->has_hessian());
}

// Three integrators in series with a ramp as input. The series is finite, so the result equals
// Horner's scheme by hand to the last digits.
TEST(ZeroOrderHold, NilpotentDynamicsAreExact) {
  IntervalProblem problem;
  problem.arguments = {3, 1, 0};
  problem.dynamics = make_function<3, 1, 0>([](const auto&, const auto& x, const auto& u) {
    using S = std::decay_t<decltype(x[0])>;
    return Vec<S, 3>(x[1], x[2], 3.0 * u[0]);
  });
  problem.shape = InputShape::linear;
  problem.differentiate_time = true;
  const auto integrator = zero_order_hold()->make(problem);
  for (const double h : {0.01, 0.37, 25.0}) {
    const double c0 = 0.7, c1 = -0.2, x = 0.3, v = -1.1, a = 0.9, d = c1 - c0;
    const VectorXd w = (VectorXd(7) << x, v, a, c0, c1, 0.0, h).finished();
    const VectorXd end = end_of(*integrator, w);
    const double last = a + 3.0 * h * (c0 + d / 2);
    const double middle = v + h * (a + 3.0 * h * (c0 / 2 + d / 6));
    const double first = x + h * (v + h * (a / 2 + 3.0 * h * (c0 / 6 + d / 24)));
    // Relative to the largest term, because the terms cancel.
    EXPECT_LE(std::abs(end[0] - first),
              1e-15 * std::max({x, -h * v, h * h * a / 2, h * h * h * c0 / 2}));
    EXPECT_LE(std::abs(end[1] - middle), 1e-15 * std::max({-v, h * a, h * h * 1.5 * c0}));
    EXPECT_LE(std::abs(end[2] - last), 1e-15 * std::max({a, 3.0 * h * c0}));
  }
}

// A Gramian computed with exp(-A') would overflow here.
TEST(ZeroOrderHold, FastDecayIsAccurate) {
  IntervalProblem problem;
  problem.arguments = {1, 0, 0};
  problem.dynamics =
      make_function<1, 0, 0>([](const auto&, const auto& x) { return -1000.0 * x[0]; });
  problem.running_cost =
      make_function<1, 0, 0>([](const auto&, const auto& x) { return x[0] * x[0]; });
  const auto integrator = zero_order_hold()->make(problem);
  const VectorXd w = (VectorXd(3) << 3.0, 0.0, 1.0).finished();
  const VectorXd end = end_of(*integrator, w);
  EXPECT_LE(end[0], 1e-300);
  EXPECT_LE(relative_error(end[1], 9.0 / 2000.0), 1e-13);
}

// x' = -x + B u + a, cost x^2 + u^2. B and a only set the units of u and 1.
TEST_P(ZeroOrderHoldBothShapes, LargeColumnsAreAccurate) {
  constexpr double tolerance = 1e-13, start = 0.7;
  const double decay = std::exp(-1.0), grown = -std::expm1(-1.0);
  const int nc = GetParam() == InputShape::linear ? 2 : 1;
  for (double B = 1.0; B < 2e12; B *= 10.0) {
    IntervalProblem problem;
    problem.arguments = {1, 1, 0};
    problem.shape = GetParam();
    problem.differentiate_time = true;
    problem.dynamics = make_function<1, 1, 0>(
        [B](const auto&, const auto& x, const auto& u) { return B * u[0] - x[0]; });
    problem.running_cost = make_function<1, 1, 0>(
        [](const auto&, const auto& x, const auto& u) { return x[0] * x[0] + u[0] * u[0]; });
    const auto integrator = zero_order_hold()->make(problem);
    for (const double u : {0.0, 0.3, 1.0 / B}) {
      VectorXd w(1 + nc + 2);
      w << start, VectorXd::Constant(nc, u), 0.0, 1.0;
      const VectorXd end = end_of(*integrator, w);
      // x(s) = r + (x - r) exp(-s), with the equilibrium r
      const double r = B * u;
      EXPECT_LE(relative_error(end[0], start * decay + r * grown), tolerance) << B;
      const double cost = r * r + 2.0 * r * (start - r) * grown -
                          0.5 * (start - r) * (start - r) * std::expm1(-2.0) + u * u;
      EXPECT_LE(std::abs(end[1] - cost), tolerance * (r * r + start * start + u * u)) << B;
      const MatrixXd slope = jacobian_of(*integrator, w);
      EXPECT_LE(relative_error(slope(0, 0), decay), tolerance) << B;
      EXPECT_LE(relative_error(slope.row(0).segment(1, nc).sum(), B * grown), tolerance) << B;
      EXPECT_LE(std::abs(slope(0, 2 + nc) - (r - start) * decay), tolerance * (r + start)) << B;
    }
    const auto offset = [B](const auto&, const auto& x) { return B - x[0]; };
    IntervalProblem free;
    free.arguments = {1, 0, 0};
    free.dynamics = make_function<1, 0, 0>(offset);
    const VectorXd end =
        end_of(*zero_order_hold()->make(free), (VectorXd(3) << 2.0 * B, 0.0, 1.0).finished());
    EXPECT_LE(relative_error(end[0], B * (1.0 + decay)), tolerance) << B;
  }
}

// Inputs that enter the cost only: the cost has forty times as many derivatives as the dynamics.
TEST(ZeroOrderHold, CostsMayDependOnMoreThanTheDynamics) {
  constexpr int inputs = 40;
  IntervalProblem problem;
  problem.arguments = {1, inputs, 0};
  problem.dynamics = make_function<1, inputs, 0>(
      [](const auto&, const auto&, const auto& u) { return 3.0 * u[0]; });
  problem.running_cost = make_function<1, inputs, 0>(
      [](const auto&, const auto& x, const auto& u) { return x[0] * x[0] + u.squaredNorm(); });
  const auto integrator = zero_order_hold()->make(problem);
  constexpr double h = 0.4, x = 0.7;
  VectorXd w(1 + inputs + 2);
  w << x, VectorXd::LinSpaced(inputs, 0.1, 1.0), 0.0, h;
  const double rate = 3.0 * w[1];
  const VectorXd end = end_of(*integrator, w);
  EXPECT_LE(relative_error(end[0], x + h * rate), 1e-15);
  EXPECT_LE(relative_error(end[1], h * (x * x + h * x * rate + h * h * rate * rate / 3.0 +
                                        w.segment(1, inputs).squaredNorm())),
            1e-14);
  expect_jacobian_matches(*integrator, w, 1e-10);
}

TEST(ZeroOrderHold, RepeatedPairsComeFromTheCacheUnchanged) {
  const auto integrator = zero_order_hold()->make(affine_problem(InputShape::linear, true, true));
  const VectorXd first = affine_point(InputShape::linear, 0.3);
  const MatrixXd expected = jacobian_of(*integrator, first);
  for (const double h : {0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.3}) {
    const MatrixXd derivative = jacobian_of(*integrator, affine_point(InputShape::linear, h));
    if (h == 0.3) {
      EXPECT_EQ(derivative, expected);
    }
  }
  VectorXd other = first;
  other[integrator->arguments().p()] += 0.5;
  EXPECT_NE(jacobian_of(*integrator, other), expected);
  EXPECT_EQ(jacobian_of(*integrator, first), expected);
}

template <class F>
std::string refusal(const Function& dynamics, F&& cost) {
  IntervalProblem problem;
  problem.arguments = {2, 1, 0};
  problem.dynamics = dynamics;
  problem.running_cost = cost;
  return error_of<DefinitionError>([&] { zero_order_hold()->make(problem); }, "accepted");
}

TEST(ZeroOrderHold, RejectsProblemsWithoutExactSolution) {
  const auto linear = make_function<2, 1, 0>([](const auto&, const auto& x, const auto& u) {
    using S = std::decay_t<decltype(x[0])>;
    return Vec<S, 2>(x[1], u[0]);
  });
  EXPECT_EQ(refusal(linear, Function{}), "accepted");
  EXPECT_EQ(refusal(make_function<2, 1, 0>([](const auto&, const auto& x, const auto& u) {
                      using S = std::decay_t<decltype(x[0])>;
                      return Vec<S, 2>(x[1], u[0] * x[1]);
                    }),
                    Function{}),
            "the exact zero-order hold needs dynamics that are affine in state and input, but they "
            "have a second derivative with respect to u[0] and x[1].");
  EXPECT_EQ(refusal(make_function<2, 1, 0>([](const auto& t, const auto& x, const auto& u) {
                      using S = std::decay_t<decltype(x[0])>;
                      return Vec<S, 2>(x[1], u[0] + t);
                    }),
                    Function{}),
            "the exact zero-order hold needs dynamics that do not depend on time, but output 1 "
            "does.");
  EXPECT_NE(refusal(make_function<2, 1, 0>([](const auto&, const auto& x, const auto& u) {
                      using S = std::decay_t<decltype(x[0])>;
                      return Vec<S, 2>(abs(x[1]), u[0]);
                    }),
                    Function{}),
            "accepted");
  const std::string remedy =
      "; runge_kutta4() integrates such costs, and costs(CostRule::nodes) sums them at the nodes.";
  EXPECT_EQ(refusal(linear, make_function<2, 1, 0>([](const auto&, const auto& x, const auto&) {
                      return x[0] * x[0] * x[0];
                    })),
            "the exact zero-order hold needs running costs that are at most quadratic in state and "
            "input, but the Hessian of cost 0 differs between two points" +
                remedy);
  EXPECT_EQ(
      refusal(linear, make_function<2, 1, 0>([](const auto& t, const auto& x, const auto&) {
                return (x[0] - t) * (x[0] - t);
              })),
      "the exact zero-order hold needs running costs that do not depend on time, but output 0 "
      "does" +
          remedy);
  EXPECT_NE(refusal(linear, make_function<2, 1, 0>(
                                [](const auto&, const auto& x, const auto&) { return abs(x[0]); })),
            "accepted");
}

TEST(ZeroOrderHold, ReportsNonFiniteMatricesAsStatus) {
  const auto integrator =
      zero_order_hold()->make(affine_problem(InputShape::constant, false, true));
  VectorXd w = affine_point(InputShape::constant, 0.3);
  w[integrator->arguments().p()] = std::nan("");
  VectorXd end(5);
  MatrixXd derivative(5, w.size());
  EXPECT_EQ(integrator->value(w.data(), end.data()), IntegrationStatus::not_finite);
  EXPECT_EQ(integrator->jacobian(w.data(), end.data(), derivative), IntegrationStatus::not_finite);
}

}  // namespace
}  // namespace saltus
