// The check does not accept saddles and maxima as optima, and it accepts flat optima.
#include "saltus/solver/optimum_check.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "tests/solver/small_programs.hpp"

namespace saltus {
namespace {

struct Integrator1 {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return Vec<S, 1>(u[0]);
  }
};

template <class Cost>
OptimalControlProblem problem(Cost cost, Bounds input = unbounded()) {
  Phase<1, 1> phase{"only", Integrator1{}, exactly(1.0)};
  phase.minimise("cost", cost).bound_input(0, input);
  OptimalControlProblem ocp("curved");
  ocp.start_at({0}).then(phase);
  return ocp;
}

std::vector<std::unique_ptr<Solver>> solvers() {
  std::vector<std::unique_ptr<Solver>> result;
  result.push_back(make_ipopt());
  result.push_back(make_native_solver());
  result.push_back(make_native_solver({.qp = riccati_qp()}));
  return result;
}

Solution solved(const OptimalControlProblem& ocp, Solver& solver) {
  MultipleShooting shooting(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
  return solve(shooting, solver);
}

TEST(SecondOrder, MaximumIsNotAnOptimum) {
  const OptimalControlProblem ocp =
      problem([](auto, auto, auto u) { return -u[0] * u[0] - 0.1 * u[0] * u[0] * u[0] * u[0]; });
  for (const auto& solver : solvers()) {
    const Solution s = solved(ocp, *solver);
    EXPECT_FALSE(s.ok()) << solver->name() << ": " << s.message;
  }
}

TEST(SecondOrder, MaximumOfAQuadraticCostIsNotAnOptimum) {
  const OptimalControlProblem ocp = problem([](auto, auto, auto u) { return -u[0] * u[0]; });
  for (const auto& solver : solvers()) {
    const Solution s = solved(ocp, *solver);
    EXPECT_FALSE(s.ok()) << solver->name() << ": " << s.message;
    EXPECT_NE(s.message.find("input 0"), std::string::npos) << solver->name() << ": " << s.message;
  }
}

TEST(SecondOrder, SaddlePointHasAHint) {
  const OptimalControlProblem ocp =
      problem([](auto, auto x, auto u) { return x[0] * x[0] - 2.0 * u[0] * u[0]; });
  for (const auto& solver : solvers()) {
    const Solution s = solved(ocp, *solver);
    EXPECT_FALSE(s.ok()) << solver->name() << ": " << s.message;
    const bool says = s.message.find("not convex") != std::string::npos ||
                      s.message.find("saddle") != std::string::npos ||
                      s.status == SolveStatus::unbounded;
    EXPECT_TRUE(says) << solver->name() << ": " << s.message;
  }
}

// A cost with negative curvature can still have a minimum at its bounds.
TEST(SecondOrder, CornerIsAnOptimum) {
  const OptimalControlProblem ocp =
      problem([](auto, auto x,
                 auto u) { return x[0] - 0.1 * u[0] * u[0] + 0.01 * u[0] * u[0] * u[0] * u[0]; },
              between(-1.0, 1.0));
  for (const auto& solver : solvers()) {
    const Solution s = solved(ocp, *solver);
    EXPECT_TRUE(s.ok()) << solver->name() << ": " << s.message;
    EXPECT_EQ(s.curvature, OptimumCheck::Curvature::minimum) << solver->name();
  }
}

// Singular arcs and inputs without cost give a semidefinite Hessian, which is not a saddle.
TEST(SecondOrder, FlatCostIsNotASaddle) {
  for (const auto& solver : solvers()) {
    const Solution singular = solved(
        problem([](auto, auto x, auto) { return (x[0] - 0.2) * (x[0] - 0.2); }, between(-1, 1)),
        *solver);
    EXPECT_TRUE(singular.ok()) << solver->name() << ": " << singular.message;
    const Solution quartic =
        solved(problem([](auto, auto, auto u) { return u[0] * u[0] * u[0] * u[0]; }), *solver);
    EXPECT_TRUE(quartic.ok()) << solver->name() << ": " << quartic.message;
  }
}

TEST(SecondOrder, DirectionHasNegativeCurvature) {
  MultipleShooting shooting(problem([](auto, auto, auto u) { return -u[0] * u[0]; }),
                            {.intervals_per_phase = 10, .integrator = runge_kutta4()});
  NlpPoint point = shooting.initial_guess();
  point.w.setZero();
  point.lambda = VectorXd::Zero(shooting.nlp().rows());
  point.z = VectorXd::Zero(shooting.nlp().variables());
  const OptimumCheck check = check_optimum(shooting.nlp(), point);
  ASSERT_EQ(check.curvature, OptimumCheck::Curvature::descent);
  double here = 0.0, there = 0.0;
  shooting.nlp().objective(point.w.data(), here);
  const VectorXd moved = point.w + 0.1 * check.direction;
  shooting.nlp().objective(moved.data(), there);
  EXPECT_LT(there, here - 1e-4);
  VectorXd rows(shooting.nlp().rows());
  shooting.nlp().constraints(moved.data(), rows.data());
  EXPECT_LT(rows.cwiseAbs().maxCoeff(), 1e-5);
}

// Without second derivatives, a small residual of a large variable promises a large decrease.
TEST(FirstOrder, ResidualCountsWithTheSizeOfItsVariable) {
  Phase<1, 1> phase{"only", Integrator1{}, exactly(1.0)};
  phase.nominal(Vec<double, 1>{1.0}, Vec<double, 1>{1.0}).minimise_at_end("cost", [](auto, auto x) {
    return 1e-8 * x[0];
  });
  OptimalControlProblem ocp("flat");
  ocp.start_at({0}).then(phase);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
  NlpPoint point = shooting.initial_guess();
  point.w.setConstant(1e5);
  point.lambda = VectorXd::Zero(shooting.nlp().rows());
  point.z = VectorXd::Zero(shooting.nlp().variables());
  EXPECT_NEAR(check_optimum(shooting.nlp(), point).gain, 1e-3, 1e-9);
}

// Second derivatives vanish at x = 0, and the cost decreases to -1 on both sides.
TEST(SecondOrder, FourthOrderMaximumIsNotAMinimum) {
  Phase<1, 1> phase{"only", Integrator1{}, exactly(1.0)};
  phase.bound_input(0, between(-1.0, 1.0)).minimise_at_end("hill", [](auto, auto x) {
    return -x[0] * x[0] * x[0] * x[0];
  });
  OptimalControlProblem ocp("hill");
  ocp.start_at({0}).then(phase);
  for (const auto& solver : solvers()) {
    const Solution s = solved(ocp, *solver);
    // A solver may leave the maximum by itself. The test requires only that the maximum is not
    // called an optimum.
    if (s.ok())
      EXPECT_NEAR(s.cost, -1.0, 1e-6) << solver->name();
    else
      EXPECT_EQ(s.status, SolveStatus::no_minimum) << solver->name() << ": " << s.message;
  }
}

// A decrease of the cost below the tolerance does not turn an optimum into a failure. A maximum is
// not an optimum, even with very small multipliers of distant bounds.
TEST(SecondOrder, DependsOnThePredictedDecrease) {
  for (const double height : {1e-9, 1.0}) {
    const OptimalControlProblem ocp = problem(
        [height](auto, auto, auto u) { return 1.0 - height * u[0] * u[0]; }, between(-1.0, 1.0));
    MultipleShooting shooting(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
    NlpPoint point = shooting.initial_guess();
    point.w.setZero();
    point.lambda = VectorXd::Zero(shooting.nlp().rows());
    point.z = VectorXd::Zero(shooting.nlp().variables());
    const OptimumCheck check = check_optimum(shooting.nlp(), point);
    EXPECT_NEAR(check.magnitude, 1.0, 1e-12);
    if (height == 1.0) {
      EXPECT_EQ(check.curvature, OptimumCheck::Curvature::descent);
      EXPECT_GT(check.descent, 0.05);  // one input of ten moves to its bound
    } else {
      EXPECT_LT(check.descent, 1e-6);
    }
  }
}

// Both first-order quantities in closed form: min (w0 - 2)^2 / 2 with w0 <= 1 at w0 = 0.9, z = 0.5.
TEST(FirstOrder, GapAndGainMatchTheEquations) {
  testing_support::Parabola program(2.0, at_most(1.0), false);
  const VectorXd w = VectorXd::Constant(1, 0.9), z = VectorXd::Constant(1, 0.5);
  const OptimumCheck check = check_optimum(program, {w, VectorXd(), z});
  EXPECT_NEAR(check.gap, 0.5 * 0.1, 1e-15);
  // The residual is -1.1 + 0.5, and the curvature is 1 + z / distance = 6.
  EXPECT_NEAR(check.gain, 0.5 * 0.6 * 0.6 / 6.0, 1e-6);
  const OptimumCheck optimum =
      check_optimum(program, {VectorXd::Ones(1), VectorXd(), VectorXd::Ones(1)});
  EXPECT_EQ(optimum.relative_gain(), 0.0);
  EXPECT_EQ(optimum.curvature, OptimumCheck::Curvature::minimum);
}

// A cost in other units has small second derivatives, which must not vanish beside those of the
// rows: the predicted decrease is proportional to the cost.
TEST(FirstOrder, GainIsProportionalToTheCost) {
  for (const bool is_linear : {true, false}) {
    const auto gain = [is_linear](double factor) {
      const OptimalControlProblem ocp = problem([=](auto, auto x, auto u) {
        return factor * ((u[0] - 1.0) * (u[0] - 1.0) + (is_linear ? 1.0 : x[0]) * x[0] * x[0]);
      });
      MultipleShooting shooting(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
      EXPECT_EQ(shooting.nlp().is_linear_quadratic(), is_linear);
      NlpPoint point = shooting.initial_guess();
      point.lambda = VectorXd::Zero(shooting.nlp().rows());
      point.z = VectorXd::Zero(shooting.nlp().variables());
      return check_optimum(shooting.nlp(), point).gain;
    };
    const double usual = gain(1.0);
    EXPECT_GT(usual, 1e-4);
    for (const double factor : {1e-3, 1e-6, 1e-9, 1e-12})
      EXPECT_NEAR(gain(factor) / (factor * usual), 1.0, 1e-2) << factor << is_linear;
  }
}

}  // namespace
}  // namespace saltus
