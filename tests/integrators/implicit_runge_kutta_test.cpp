// Tests Gauss-Legendre and Radau IIA: coefficients, measured orders, exact discrete derivatives,
// stability, failures. scheme_instructions.cpp counts their instructions.
#include "saltus/integrators/runge_kutta.hpp"

#include <string>

#include "saltus/core/error.hpp"
#include "saltus/integrators/sundials.hpp"
#include "tests/integrators/support.hpp"

namespace saltus {
namespace {

using namespace test;

// Differences of functions of order one with the step of differences(): measured below 1e-11.
constexpr double difference_error = 1e-10;

struct Family {
  const char* name;
  IntegratorChoice (*scheme)(ImplicitRungeKuttaOptions);
  ButcherTableau (*tableau)(int);
};
constexpr Family families[] = {{"Gauss", gauss_legendre, gauss_legendre_tableau},
                               {"Radau", radau_iia, radau_iia_tableau}};

class ImplicitSchemes : public ::testing::TestWithParam<std::tuple<int, int>> {
 protected:
  const Family& family() const { return families[std::get<0>(GetParam())]; }
  int stages() const { return std::get<1>(GetParam()); }
  IntegratorChoice scheme(int steps) const {
    return family().scheme({.stages = stages(), .steps = steps});
  }
};
INSTANTIATE_TEST_SUITE_P(Families, ImplicitSchemes,
                         ::testing::Combine(::testing::Values(0, 1), ::testing::Values(1, 2, 3, 4)),
                         [](const auto& param) {
                           return std::string(families[std::get<0>(param.param)].name) +
                                  std::to_string(std::get<1>(param.param));
                         });

IntervalProblem autonomous(Function dynamics) {
  IntervalProblem problem;
  problem.arguments = {dynamics.outputs(), 0, 0};
  problem.dynamics = std::move(dynamics);
  return problem;
}

// w = (x0 | t0 = 0 | h)
VectorXd from(const VectorXd& start, double length) {
  VectorXd w(start.size() + 2);
  w << start, 0.0, length;
  return w;
}

// x' = -x^2 / c from c: the relative result is the same for every c and every nominal magnitude of
// the state.
TEST_P(ImplicitSchemes, SmallStatesAreAsAccurateAsLargeOnes) {
  const auto scaled = [&](double c) {
    const auto field = [c](const auto&, const auto& x) {
      return std::decay_t<decltype(x)>{-x[0] * x[0] / c};
    };
    const auto integrator = scheme(2)->make(autonomous(make_function<1, 0, 0>(field)));
    const VectorXd w = from(VectorXd{{c}}, 1.0);
    return std::pair{end_of(*integrator, w)[0] / c, jacobian_of(*integrator, w)(0, 0)};
  };
  const auto [end, derivative] = scaled(1.0);
  for (double c = 0.1; c > 5e-13; c *= 0.1) {
    const auto [small, small_derivative] = scaled(c);
    // Rounding error of a few products.
    EXPECT_NEAR(small, end, 1e-14) << c;
    EXPECT_NEAR(small_derivative, derivative, 1e-13) << c;
  }
}

// The simplifying conditions B(order) and C(stages), which define the methods.
TEST_P(ImplicitSchemes, CoefficientsIntegratePolynomials) {
  const ButcherTableau tableau = family().tableau(stages());
  constexpr double rounding = 4e-16;
  for (int k = 1; k <= tableau.order; ++k) {
    const VectorXd power = tableau.c.array().pow(k - 1);
    EXPECT_NEAR(tableau.b.dot(power), 1.0 / k, rounding);
    if (k > stages()) continue;
    const VectorXd inside = tableau.a * power;
    for (int i = 0; i < stages(); ++i)
      EXPECT_NEAR(inside[i], std::pow(tableau.c[i], k) / k, rounding);
  }
}

TEST_P(ImplicitSchemes, HaveTheExpectedOrderInStateAndSensitivity) {
  VectorXd w = coupled_point(InputShape::linear);
  const auto reference = runge_kutta8({.steps = 100})->make(coupled_problem(InputShape::linear));
  w[reference->arguments().h()] = 1.0;
  const VectorXd end = end_of(*reference, w);
  const MatrixXd slope = jacobian_of(*reference, w);
  const int order = family().tableau(stages()).order;
  const int steps = order < 5 ? 16 : 2;
  const auto coarse = scheme(steps)->make(coupled_problem(InputShape::linear));
  const auto fine = scheme(2 * steps)->make(coupled_problem(InputShape::linear));
  const auto measured = [](double coarse_error, double fine_error) {
    return std::log2(coarse_error / fine_error);
  };
  EXPECT_NEAR(measured((end_of(*coarse, w) - end).norm(), (end_of(*fine, w) - end).norm()), order,
              0.3);
  EXPECT_NEAR(
      measured((jacobian_of(*coarse, w) - slope).norm(), (jacobian_of(*fine, w) - slope).norm()),
      order, 0.3);
}

TEST_P(ImplicitSchemes, DerivativesOfFirstAndSecondOrderAreExact) {
  const VectorXd weights = (VectorXd(5) << 0.7, -1.3, 0.4, 0.9, -0.6).finished();
  for (const InputShape shape : {InputShape::constant, InputShape::linear})
    for (const int steps : {1, 3}) {
      const auto integrator = scheme(steps)->make(coupled_problem(shape));
      expect_jacobian_matches(*integrator, coupled_point(shape), difference_error);
      expect_hessian_matches(*integrator, coupled_point(shape), weights, difference_error);
    }
}

TEST_P(ImplicitSchemes, GaussNewtonIsExactForAffineDynamics) {
  for (const InputShape shape : {InputShape::constant, InputShape::linear}) {
    const auto integrator = scheme(2)->make(affine_problem(shape, false, false));
    const VectorXd w = affine_point(shape, 0.4);
    const VectorXd weights = (VectorXd(5) << 0.7, -1.3, 0.4, 0.9, -0.6).finished();
    const MatrixXd exact = hessian_of(*integrator, w, weights);
    EXPECT_GT(exact.norm(), 0.1);
    EXPECT_LE((exact - hessian_of(*integrator, w, weights, Curvature::gauss_newton)).norm(), 1e-14);
  }
}

TEST_P(ImplicitSchemes, LengthZeroIsTheIdentity) {
  const auto integrator = scheme(2)->make(coupled_problem(InputShape::constant));
  VectorXd w = coupled_point(InputShape::constant);
  w[integrator->arguments().h()] = 0.0;
  EXPECT_EQ(end_of(*integrator, w).head(3), w.head(3));
  constexpr double rounding = 1e-14;
  EXPECT_LE((jacobian_of(*integrator, w).topLeftCorner(3, 3) - MatrixXd::Identity(3, 3)).norm(),
            rounding);
}

// One step over an oscillation or a decay of any speed never grows (A-stability). Gauss-Legendre
// keeps the amplitude of an oscillation; Radau IIA damps fast modes.
TEST_P(ImplicitSchemes, AreStableForAnyStep) {
  const bool gauss = std::get<0>(GetParam()) == 0;
  const IntervalProblem decay =
      autonomous(make_function<1, 0, 0>([](const auto&, const auto& x) { return -x[0]; }));
  const IntervalProblem oscillator =
      autonomous(make_function<2, 0, 0>([](const auto&, const auto& x) {
        return std::decay_t<decltype(x)>{x[1], -x[0]};
      }));
  const auto damped = scheme(1)->make(decay), turned = scheme(1)->make(oscillator);
  constexpr double rounding = 1e-13;
  for (double speed = 1e-3; speed < 1e9; speed *= 3.0) {
    const double left = std::abs(end_of(*damped, from(VectorXd::Ones(1), speed))[0]);
    const double size = end_of(*turned, from((VectorXd(2) << 0.6, 0.8).finished(), speed)).norm();
    EXPECT_LE(left, 1.0 + rounding) << speed;
    EXPECT_LE(size, 1.0 + rounding) << speed;
    if (gauss) {
      EXPECT_GE(size, 1.0 - rounding) << speed;
    } else if (speed > 1e6) {
      EXPECT_LE(left, 1e-5) << speed;
    }
  }
}

TEST_P(ImplicitSchemes, ReportFailuresAsStatus) {
  expect_undefined(*scheme(1));
  const VectorXd w = from(VectorXd::Constant(1, -1.0), 1.0);
  VectorXd end(1);
  // x' = x^2 + 25 is infinite after 0.35 s. The stage equations of the second of two steps have no
  // solution.
  const auto parabola = scheme(2)->make(autonomous(
      make_function<1, 0, 0>([](const auto&, const auto& x) { return x[0] * x[0] + 25.0; })));
  EXPECT_EQ(parabola->value(w.data(), end.data()), IntegrationStatus::step_too_small);
  EXPECT_NE(parabola->failure().find("Newton's method failed in step 1 of 2"), std::string::npos)
      << parabola->failure();
}

// Van der Pol's oscillator with mu = 1e3 on its slow branch. The steps are 1e5 times its fast time
// constant.
TEST(ImplicitRungeKutta, FollowsAStiffBranchWithLongSteps) {
  const IntervalProblem problem = autonomous(make_function<2, 0, 0>([](const auto&, const auto& x) {
    return std::decay_t<decltype(x)>{x[1], 1e3 * (1.0 - x[0] * x[0]) * x[1] - x[0]};
  }));
  const VectorXd w = from((VectorXd(2) << 2.0, -2.0 / 3e3).finished(), 500.0);
  const VectorXd reference =
      end_of(*cvodes({.tolerance = 1e-13, .absolute_tolerance = 1e-16})->make(problem), w);
  const auto radau = radau_iia({.stages = 3, .steps = 10})->make(problem);
  EXPECT_LE((end_of(*radau, w) - reference).cwiseAbs().maxCoeff(), 1e-6);
  VectorXd end(2);
  const auto explicit_scheme = runge_kutta8({.steps = 1000})->make(problem);
  EXPECT_EQ(explicit_scheme->value(w.data(), end.data()), IntegrationStatus::not_finite);
}

// Newton's method diverges where the rate saturates. Continuation through several shorter steps
// converges; starting from half of the step is not enough.
TEST(ImplicitRungeKutta, FindsStagesWithShorterSteps) {
  constexpr double rate = 1e3, start = 3.0;
  const IntervalProblem problem = autonomous(
      make_function<1, 0, 0>([](const auto&, const auto& x) { return -rate * atan(x[0]); }));
  const VectorXd w = from(VectorXd::Constant(1, start), 1.0);
  // Solves x + a rate atan(x) = start from a point where Newton's method converges.
  const auto stage = [](double a) {
    double x = 0.0;
    for (int k = 0; k < 20; ++k)
      x -= (x + a * rate * std::atan(x) - start) / (1.0 + a * rate / (1.0 + x * x));
    return x;
  };
  EXPECT_NEAR(end_of(*gauss_legendre({.stages = 1, .steps = 1})->make(problem), w)[0],
              2.0 * stage(0.5) - start, 1e-12);
  EXPECT_NEAR(end_of(*radau_iia({.stages = 1, .steps = 1})->make(problem), w)[0], stage(1.0),
              1e-12);
}

TEST(ImplicitRungeKutta, RejectsUnsupportedProblems) {
  EXPECT_THROW(gauss_legendre({.stages = 0}), DefinitionError);
  EXPECT_THROW(radau_iia({.stages = 5}), DefinitionError);
  EXPECT_THROW(radau_iia({.stages = 2, .steps = 0}), DefinitionError);
  EXPECT_THROW(runge_kutta(gauss_legendre_tableau(2)), DefinitionError);  // not explicit
  EXPECT_EQ(radau_iia({.stages = 3, .steps = 4})->name(), "Radau IIA 5, 4 steps");
}

}  // namespace
}  // namespace saltus
