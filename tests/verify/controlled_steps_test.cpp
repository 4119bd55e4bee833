// Integrators of the verifier: orders, dense output, stiffness, and steps independent of a grid.
#include "saltus/verify/controlled_steps.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "saltus/model/make_function.hpp"

namespace saltus {
namespace {

constexpr double two_pi = 6.283185307179586;

Plan::Interval interval(double start, double length, VectorXd state, VectorXd input) {
  return {0, start, length, std::move(state), std::move(input), {}};
}

TEST(ControlledSteps, IntegrateAnOscillatorToTolerance) {
  const Function f = make_function<2, 0, 0>([](const auto&, const auto& x) {
    return std::decay_t<decltype(x)>{x[1], -x[0]};
  });
  const Plan::Interval i = interval(0.0, 10.0, VectorXd{{1.0, 0.0}}, {});
  const VectorXd none;
  for (const double tolerance : {1e-6, 1e-9, 1e-12}) {
    PlanField field({2, 0, 0}, f, {}, InputShape::constant);
    field.load(i, none);
    ControlledSteps steps(field, tolerance);
    steps.begin(0.0, i.state.data());
    double worst_inside = 0.0;
    std::vector<double> inside(2);
    while (!steps.is_at_end()) {
      ASSERT_TRUE(steps.step());
      for (const double theta : {0.2, 0.5, 0.8}) {
        steps.state_at(theta, inside.data());
        const double t = 10.0 * (steps.step_start() + theta * steps.step_length());
        worst_inside = std::max(worst_inside, std::abs(inside[0] - std::cos(t)));
      }
    }
    EXPECT_NEAR(steps.state()[0], std::cos(10.0), 100.0 * tolerance);
    EXPECT_NEAR(steps.state()[1], -std::sin(10.0), 100.0 * tolerance);
    EXPECT_LT(worst_inside, 200.0 * tolerance);
    EXPECT_FALSE(steps.is_implicit());
  }
}

// x' = -k (x - cos t): explicit steps of length 1 / k would number thousands.
TEST(ControlledSteps, SwitchToImplicitStepsForStiffFields) {
  constexpr double k = 1e6;
  const Function f = make_function<1, 0, 0>(
      [](const auto& t, const auto& x) { return std::decay_t<decltype(x)>{-k * (x[0] - cos(t))}; });
  const Plan::Interval i = interval(0.0, 2.0, VectorXd{{0.0}}, {});
  const VectorXd none;
  PlanField field({1, 0, 0}, f, {}, InputShape::constant);
  field.load(i, none);
  ControlledSteps steps(field, 1e-9);
  steps.begin(0.0, i.state.data());
  int count = 0;
  for (; !steps.is_at_end(); ++count) ASSERT_TRUE(steps.step());
  EXPECT_TRUE(steps.is_implicit());
  EXPECT_LT(count, 2000);
  // x = (k^2 cos t + k sin t) / (k^2 + 1) once the transient is over.
  EXPECT_NEAR(steps.state()[0], (k * k * std::cos(2.0) + k * std::sin(2.0)) / (k * k + 1.0), 1e-8);
}

// Each interval contains a whole number of periods. Equal steps sample only one phase of the
// forcing.
TEST(ControlledSteps, DetectForcingAtTheGridFrequency) {
  for (const double periods : {1.0, 4.0, 8.0, 30.0, 60.0, 360.0}) {
    const Function f = make_function<1, 0, 0>([periods](const auto& t, const auto&) {
      const auto s = sin(0.5 * two_pi * periods * t);
      return Vec<std::decay_t<decltype(t)>, 1>{s * s};
    });
    const Plan::Interval i = interval(0.0, 1.0, VectorXd{{0.0}}, {});
    const VectorXd none;
    PlanField field({1, 0, 0}, f, {}, InputShape::constant);
    field.load(i, none);
    ControlledSteps steps(field, 1e-9);
    steps.begin(0.0, i.state.data());
    while (!steps.is_at_end()) ASSERT_TRUE(steps.step());
    EXPECT_NEAR(steps.state()[0], 0.5, 1e-6) << periods;
  }
}

TEST(ControlledSteps, ReportWhereTheFieldIsUndefined) {
  const Function f = make_function<1, 0, 0>([](const auto& t, const auto& x) {
    return std::decay_t<decltype(x)>{sqrt(0.5 - t) + 0.0 * x[0]};
  });
  const Plan::Interval i = interval(0.0, 1.0, VectorXd{{0.0}}, {});
  const VectorXd none;
  PlanField field({1, 0, 0}, f, {}, InputShape::constant);
  field.load(i, none);
  ControlledSteps steps(field, 1e-9);
  steps.begin(0.0, i.state.data());
  bool works = true;
  while (works && !steps.is_at_end()) works = steps.step();
  EXPECT_FALSE(works);
}

}  // namespace
}  // namespace saltus
