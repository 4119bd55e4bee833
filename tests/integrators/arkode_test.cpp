// ARKODE: measured orders with fixed steps, agreement under error control, stiff problems.
#include "saltus/integrators/sundials.hpp"

#include "problems/library/initial_value_problems.hpp"
#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "tests/integrators/support.hpp"

namespace saltus {
namespace {

using namespace test;
using namespace library;

struct Method {
  ArkodeOptions::Method method;
  int order;
  int steps;  // chosen so that the error is well above rounding and in the asymptotic range
};

class ArkodeMethods : public testing::TestWithParam<Method> {};
INSTANTIATE_TEST_SUITE_P(Orders, ArkodeMethods,
                         testing::Values(Method{ArkodeOptions::Method::Explicit, 2, 16},
                                         Method{ArkodeOptions::Method::Explicit, 3, 16},
                                         Method{ArkodeOptions::Method::Explicit, 4, 8},
                                         Method{ArkodeOptions::Method::Explicit, 5, 8},
                                         Method{ArkodeOptions::Method::Explicit, 6, 4},
                                         Method{ArkodeOptions::Method::Explicit, 8, 2},
                                         Method{ArkodeOptions::Method::DiagonallyImplicit, 2, 16},
                                         Method{ArkodeOptions::Method::DiagonallyImplicit, 3, 16},
                                         Method{ArkodeOptions::Method::DiagonallyImplicit, 4, 8},
                                         Method{ArkodeOptions::Method::DiagonallyImplicit, 5, 8}),
                         [](const auto& param) {
                           return (param.param.method == ArkodeOptions::Method::Explicit
                                       ? "explicit"
                                       : "implicit") +
                                  std::to_string(param.param.order);
                         });

TEST_P(ArkodeMethods, HaveTheirOrderWithFixedSteps) {
  const InputShape shape = InputShape::linear;
  const VectorXd w = coupled_point(shape);
  const auto reference = runge_kutta8({.steps = 60})->make(coupled_problem(shape));
  const auto error = [&](int steps) {
    const auto integrator = arkode({.method = GetParam().method,
                                    .order = GetParam().order,
                                    .tolerance = 1e-13,
                                    .absolute_tolerance = 1e-14,
                                    .fixed_steps = steps})
                                ->make(coupled_problem(shape));
    return std::pair{(end_of(*integrator, w) - end_of(*reference, w)).norm(),
                     (jacobian_of(*integrator, w) - jacobian_of(*reference, w)).norm()};
  };
  const auto coarse = error(GetParam().steps), fine = error(2 * GetParam().steps);
  const double state = std::log2(coarse.first / fine.first);
  const double sensitivity = std::log2(coarse.second / fine.second);
  RecordProperty("order", std::to_string(state) + " " + std::to_string(sensitivity));
  EXPECT_NEAR(state, GetParam().order, 0.6) << coarse.first << " " << fine.first;
  EXPECT_NEAR(sensitivity, GetParam().order, 0.6) << coarse.second << " " << fine.second;
}

TEST_P(ArkodeMethods, AgreesWithOrderEightUnderErrorControl) {
  // Low orders would need very many steps for tight tolerances.
  const double tolerance = GetParam().order < 3 ? 1e-6 : GetParam().order < 4 ? 1e-8 : 1e-11;
  for (const auto shape : {InputShape::constant, InputShape::linear}) {
    const IntervalProblem problem = coupled_problem(shape);
    const auto integrator = arkode({.method = GetParam().method,
                                    .order = GetParam().order,
                                    .tolerance = tolerance,
                                    .absolute_tolerance = 0.1 * tolerance})
                                ->make(problem);
    const auto reference = runge_kutta8({.steps = 60})->make(problem);
    for (const double h : {0.6, 0.0, -0.3}) {
      VectorXd w = coupled_point(shape);
      w[integrator->arguments().h()] = h;
      // Bound on the global error: a hundred times the local tolerance.
      EXPECT_LE((end_of(*integrator, w) - end_of(*reference, w)).cwiseAbs().maxCoeff(),
                100.0 * tolerance);
      EXPECT_LE((jacobian_of(*integrator, w) - jacobian_of(*reference, w)).cwiseAbs().maxCoeff(),
                100.0 * tolerance);
    }
  }
}

// With fixed steps the sensitivities are those of the discrete map.
TEST_P(ArkodeMethods, FixedStepSensitivitiesMatchTheSteps) {
  for (const auto shape : {InputShape::constant, InputShape::linear}) {
    const auto integrator = arkode({.method = GetParam().method,
                                    .order = GetParam().order,
                                    .tolerance = 1e-13,
                                    .absolute_tolerance = 1e-15,
                                    .fixed_steps = 3})
                                ->make(coupled_problem(shape));
    // The implicit stages are solved to about 1e-13. Differences divide that error by 1e-3.
    expect_jacobian_matches(*integrator, coupled_point(shape), 1e-9);
  }
}

TEST(Arkode, SolvesStiffVanDerPol) {  // D01
  const auto integrator = arkode({.method = ArkodeOptions::Method::DiagonallyImplicit,
                                  .order = 5,
                                  .tolerance = 1e-11,
                                  .absolute_tolerance = 1e-13})
                              ->make(van_der_pol(1.0, 1e3));
  const VectorXd w = (VectorXd(4) << 2.0, 0.0, 0.0, 2000.0).finished();
  const VectorXd end = end_of(*integrator, w);
  EXPECT_LE(relative_error(end[0], 1.70616773217042), 1e-9);
  EXPECT_LE(relative_error(end[1], -8.92809701024858e-4), 1e-9);
}

TEST(Arkode, SolvesRobertson) {  // D02
  for (const int order : {3, 4, 5}) {
    const auto integrator = arkode({.method = ArkodeOptions::Method::DiagonallyImplicit,
                                    .order = order,
                                    .tolerance = order == 3 ? 1e-9 : 1e-11,
                                    .absolute_tolerance = order == 3 ? 1e-11 : 1e-13})
                                ->make(robertson());
    const VectorXd end = end_of(*integrator, robertson_point(4e4));
    const Eigen::Vector3d expected{3.89833770855e-2, 1.62176831591e-7, 0.961016460738};
    for (int i = 0; i < 3; ++i)
      EXPECT_LE(relative_error(end[i], expected[i]), order == 3 ? 1e-7 : 1e-9) << order;
  }
}

TEST(Arkode, MatchesRobertsonSensitivities) {  // D02
  const auto integrator = arkode({.method = ArkodeOptions::Method::DiagonallyImplicit,
                                  .order = 5,
                                  .tolerance = 1e-11,
                                  .absolute_tolerance = 1e-13})
                              ->make(robertson());
  expect_robertson_sensitivities(*integrator);
}

TEST(Arkode, ArenstorfOrbitCloses) {  // D06
  const auto integrator =
      arkode({.order = 8, .tolerance = 1e-13, .absolute_tolerance = 1e-15})->make(arenstorf());
  const VectorXd w = arenstorf_point();
  EXPECT_LE((end_of(*integrator, w).head(4) - w.head(4)).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(Arkode, ReportsFailuresAsStatus) {
  for (const auto method :
       {ArkodeOptions::Method::Explicit, ArkodeOptions::Method::DiagonallyImplicit})
    expect_undefined(*arkode({.method = method, .order = 4}));
  IntervalProblem problem;
  problem.arguments = {1, 0, 0};
  problem.dynamics = make_function<1, 0, 0>([](const auto&, const auto& x) { return x[0] * x[0]; });
  const VectorXd w = (VectorXd(3) << 1.0, 0.0, 0.5).finished();
  VectorXd end(1);
  EXPECT_EQ(arkode({.max_steps = 3})->make(problem)->value(w.data(), end.data()),
            IntegrationStatus::too_many_steps);
}

// With huge rates ARKODE chooses a first step of zero, returns a success and leaves the state.
TEST(Arkode, ReportsAFirstStepOfZero) {
  IntervalProblem problem;
  problem.arguments = {1, 0, 1};
  problem.dynamics =
      make_function<1, 0, 1>([](const auto&, const auto& x, const auto&, const auto& p) {
        return std::decay_t<decltype(x)>(p[0]);
      });
  VectorXd end(1);
  for (const auto method :
       {ArkodeOptions::Method::Explicit, ArkodeOptions::Method::DiagonallyImplicit}) {
    const auto integrator = arkode({.method = method, .order = 4})->make(problem);
    for (const double rate : {1e290, 1e300, 1e307}) {
      const VectorXd w{{0.0, rate, 0.0, 0.01}};
      const IntegrationStatus status = integrator->value(w.data(), end.data());
      if (status == IntegrationStatus::success) {
        EXPECT_NEAR(end[0], 0.01 * rate, 1e-6 * rate);
      }
    }
  }
}

TEST(Arkode, OptionsAreChecked) {
  EXPECT_THROW(arkode({.absolute_tolerance = infinity}), DefinitionError);
  EXPECT_THROW(arkode({.order = 7}), DefinitionError);
  EXPECT_THROW(arkode({.method = ArkodeOptions::Method::DiagonallyImplicit, .order = 6}),
               DefinitionError);
  EXPECT_THROW(arkode({.tolerance = -1.0}), DefinitionError);
  EXPECT_THROW(arkode({.fixed_steps = -1}), DefinitionError);
}

}  // namespace
}  // namespace saltus
