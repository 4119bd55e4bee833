// CVODES on problems with known answers: stiff, orbital, and its sensitivities.
#include "saltus/integrators/sundials.hpp"

#include <malloc.h>

#include "problems/library/initial_value_problems.hpp"
#include "saltus/core/bounds.hpp"
#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials_support.hpp"
#include "tests/integrators/support.hpp"

namespace saltus {
namespace {

using namespace test;
using namespace library;

class CvodesBothMethods : public testing::TestWithParam<CvodesOptions::Method> {};
INSTANTIATE_TEST_SUITE_P(Methods, CvodesBothMethods,
                         testing::Values(CvodesOptions::Method::Bdf, CvodesOptions::Method::Adams),
                         [](const auto& param) {
                           return param.param == CvodesOptions::Method::Bdf ? "bdf" : "adams";
                         });

TEST_P(CvodesBothMethods, AgreesWithOrderEight) {
  for (const auto shape : {InputShape::constant, InputShape::linear}) {
    for (const auto order :
         {CvodesOptions::Sensitivity::staggered, CvodesOptions::Sensitivity::simultaneous}) {
      const IntervalProblem problem = coupled_problem(shape);
      const auto integrator = cvodes({.method = GetParam(),
                                      .tolerance = 1e-11,
                                      .absolute_tolerance = 1e-13,
                                      .sensitivity = order})
                                  ->make(problem);
      const auto reference = runge_kutta8({.steps = 60})->make(problem);
      for (const double h : {0.6, 0.0, -0.3}) {
        VectorXd w = coupled_point(shape);
        w[integrator->arguments().h()] = h;
        // Bound on the global error: a hundred times the local tolerance.
        EXPECT_LE((end_of(*integrator, w) - end_of(*reference, w)).cwiseAbs().maxCoeff(), 1e-9);
        EXPECT_LE((jacobian_of(*integrator, w) - jacobian_of(*reference, w)).cwiseAbs().maxCoeff(),
                  1e-9);
      }
    }
  }
}

TEST(Cvodes, SolvesStiffVanDerPol) {  // D01, both scalings
  const auto scheme = cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-14});
  {
    const auto integrator = scheme->make(van_der_pol(1.0, 1e3));
    const VectorXd w = (VectorXd(4) << 2.0, 0.0, 0.0, 2000.0).finished();
    const VectorXd end = end_of(*integrator, w);
    EXPECT_LE(relative_error(end[0], 1.70616773217042), 1e-9);
    EXPECT_LE(relative_error(end[1], -8.92809701024858e-4), 1e-9);
  }
  {
    const auto integrator = scheme->make(van_der_pol(1e6, 1e6));
    const VectorXd w = (VectorXd(4) << 2.0, 0.0, 0.0, 2.0).finished();
    const VectorXd end = end_of(*integrator, w);
    EXPECT_LE(relative_error(end[0], 1.70616773217041), 1e-9);
    EXPECT_LE(relative_error(end[1], -0.892809701024870), 1e-9);
  }
}

TEST(Cvodes, SolvesRobertson) {  // D02
  const auto integrator =
      cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-13})->make(robertson());
  const std::vector<std::pair<double, Eigen::Vector3d>> expected{
      {0.4, {0.985172113861, 3.38639537898e-5, 1.47940221852e-2}},
      {40.0, {0.715827068719, 9.18553476456e-6, 0.284163745746}},
      {4e4, {3.89833770855e-2, 1.62176831591e-7, 0.961016460738}}};
  for (const auto& [time, reference] : expected) {
    const VectorXd end = end_of(*integrator, robertson_point(time));
    for (int i = 0; i < 3; ++i)
      EXPECT_LE(relative_error(end[i], reference[i]), 1e-9) << time << " " << i;
  }
}

TEST(Cvodes, MatchesRobertsonSensitivities) {  // D02
  for (const auto order :
       {CvodesOptions::Sensitivity::staggered, CvodesOptions::Sensitivity::simultaneous}) {
    const auto integrator =
        cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-13, .sensitivity = order})
            ->make(robertson());
    expect_robertson_sensitivities(*integrator);
  }
}

TEST(Cvodes, ArenstorfOrbitCloses) {  // D06
  const auto integrator =
      cvodes(
          {.method = CvodesOptions::Method::Adams, .tolerance = 1e-13, .absolute_tolerance = 1e-15})
          ->make(arenstorf());
  const VectorXd w = arenstorf_point();
  const VectorXd end = end_of(*integrator, w);
  EXPECT_LE((end.head(4) - w.head(4)).cwiseAbs().maxCoeff(), 1e-7);
}

TEST(Cvodes, ReportsFailuresAsStatus) {
  for (const auto method : {CvodesOptions::Method::Bdf, CvodesOptions::Method::Adams})
    expect_undefined(*cvodes({.method = method}));
  // x' = x^2 has a finite escape time, t = 1 / x0.
  IntervalProblem problem;
  problem.arguments = {1, 0, 0};
  problem.dynamics = make_function<1, 0, 0>([](const auto&, const auto& x) { return x[0] * x[0]; });
  VectorXd w = (VectorXd(3) << 1.0, 0.0, 2.0).finished(), end(1);
  const auto blow_up = cvodes({})->make(problem);
  EXPECT_NE(blow_up->value(w.data(), end.data()), IntegrationStatus::success);
  const auto short_of_steps = cvodes({.max_steps = 3})->make(problem);
  w << 1.0, 0.0, 0.5;
  EXPECT_EQ(short_of_steps->value(w.data(), end.data()), IntegrationStatus::too_many_steps);
  // The same object then solves another problem.
  EXPECT_EQ(blow_up->value(w.data(), end.data()), IntegrationStatus::success);
  EXPECT_NEAR(end[0], 2.0, 1e-7);
}

// Reference sizes of the sensitivities: states count by their typical size, parameters and the
// length by their values. The start time does not enter, since it is not a measure of duration.
TEST(Cvodes, SensitivityScalesExcludeTheStart) {
  IntervalProblem problem;
  problem.arguments = {1, 1, 1};
  problem.nominal_state = VectorXd::Constant(1, 4.0);
  const VectorXd w = (VectorXd(5) << 100.0, 100.0, -8.0, 1024.0, 0.125).finished();  // x c p t0 h
  VectorXd scales(5);
  for (int i = 0; i < 5; ++i) scales[i] = sundials::direction_scale(problem, w.data(), i);
  EXPECT_EQ(scales, (VectorXd(5) << 4.0, 1.0, 8.0, 1.0, 0.125).finished());
}

// x' = -x + p sin 10 t: dx/dp does not depend on p, even for very small p.
TEST(Cvodes, SensitivitiesToSmallParametersAreAccurate) {
  IntervalProblem problem;
  problem.arguments = {1, 0, 1};
  problem.differentiate_parameter = {true};
  problem.dynamics =
      make_function<1, 0, 1>([](const auto& t, const auto& x, const auto&, const auto& p) {
        return std::decay_t<decltype(x)>{-x[0] + p[0] * sin(10.0 * t)};
      });
  const double exact = (std::sin(10.0) - 10.0 * std::cos(10.0) + 10.0 * std::exp(-1.0)) / 101.0;
  const ArkodeOptions implicit{.method = ArkodeOptions::Method::DiagonallyImplicit, .order = 4};
  for (const IntegratorChoice& scheme : {cvodes(), cvodes({.method = CvodesOptions::Method::Adams}),
                                         idas(), arkode(), arkode(implicit)}) {
    const auto integrator = scheme->make(problem);
    for (const double p : {1.0, 1e-3, 1e-6, 1e-8, 1e-9, 1e-10, 1e-12}) {
      const VectorXd w = (VectorXd(4) << 0.0, p, 0.0, 1.0).finished();
      // Tolerances of 1e-8, accumulated over a hundred steps.
      EXPECT_LT(relative_error(jacobian_of(*integrator, w)(0, 1), exact), 1e-6)
          << scheme->name() << ", p = " << p;
    }
  }
}

#ifdef __GLIBC__
TEST(Cvodes, FreesItsMemory) {
  const auto scheme = cvodes({.tolerance = 1e-8});
  const auto in_use_after = [&](int rounds) {
    for (int i = 0; i < rounds; ++i) scheme->make(robertson());
    return mallinfo2().uordblks;
  };
  const std::size_t before = in_use_after(1);     // includes objects that exist once
  EXPECT_LT(in_use_after(1000), before + 10000);  // one context per integrator would take 270 kB
}
#endif

TEST(Cvodes, OptionsAreChecked) {
  EXPECT_THROW(cvodes({.tolerance = 0.0}), DefinitionError);
  EXPECT_THROW(cvodes({.absolute_tolerance = -1.0}), DefinitionError);
  EXPECT_THROW(cvodes({.absolute_tolerance = infinity}), DefinitionError);
  EXPECT_THROW(idas({.absolute_tolerance = infinity}), DefinitionError);
  EXPECT_THROW(cvodes({.max_steps = 0}), DefinitionError);
  IntervalProblem problem = robertson();
  problem.nominal_state = VectorXd::Ones(2);
  EXPECT_THROW(cvodes()->make(problem), DefinitionError);
}

TEST(Idas, ReportsAnInfiniteFirstSlope) {
  IntervalProblem problem;
  problem.arguments = {1, 0, 1};
  problem.dynamics =
      make_function<1, 0, 1>([](const auto&, const auto& x, const auto&, const auto& p) {
        return std::decay_t<decltype(x)>(p[0]);
      });
  const VectorXd w{{0.0, infinity, 0.0, 1.0}};
  VectorXd end(1);
  EXPECT_EQ(idas()->make(problem)->value(w.data(), end.data()), IntegrationStatus::not_finite);
}

// With huge rates CVODES chooses a first step of zero, returns a success and leaves the state.
TEST(Cvodes, ReportsAFirstStepOfZero) {
  IntervalProblem problem;
  problem.arguments = {2, 0, 1};
  problem.dynamics =
      make_function<2, 0, 1>([](const auto&, const auto& x, const auto&, const auto& p) {
        return std::decay_t<decltype(x)>(1e10 * x[1], p[0]);
      });
  VectorXd w(5), end(2);
  for (const auto method : {CvodesOptions::Method::Bdf, CvodesOptions::Method::Adams}) {
    const auto integrator =
        cvodes({.method = method, .tolerance = 1e-10, .absolute_tolerance = 1e-10})->make(problem);
    for (const double rate : {1e300, 1e305, 1e307}) {
      w << 0.0, 0.0, rate, 0.0, 0.01;
      const IntegrationStatus status = integrator->value(w.data(), end.data());
      if (status == IntegrationStatus::success) {
        EXPECT_NEAR(end[1], 0.01 * rate, 1e-6 * rate);
      }
    }
  }
}

}  // namespace
}  // namespace saltus
