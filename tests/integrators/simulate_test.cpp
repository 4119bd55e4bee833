// Simulation over several intervals: steps in the input, accumulated costs, failures.
#include "saltus/integrators/simulate.hpp"

#include "saltus/core/error.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "tests/integrators/support.hpp"

namespace saltus {
namespace {

using namespace test;

TEST(Simulate, AgreesWithTheExactSolutionAcrossInputSteps) {
  const IntervalProblem problem = affine_problem(InputShape::constant, false, false);
  const auto tight = cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-14})->make(problem);
  const auto exact = zero_order_hold()->make(problem);
  const VectorXd x0 = (VectorXd(3) << 0.4, -0.7, 0.2).finished();
  const VectorXd times = (VectorXd(4) << 1.0, 1.013, 1.013, 1.5).finished();
  MatrixXd inputs(2, 3);
  inputs << 3.0, 100.0, -2.0, 0.0, 7.0, 1.0;
  const VectorXd p = (VectorXd(2) << 1.1, 0.9).finished();
  const Simulation a = simulate(*tight, x0, times, inputs, p);
  const Simulation b = simulate(*exact, x0, times, inputs, p);
  ASSERT_EQ(a.status, IntegrationStatus::success);
  EXPECT_EQ(a.intervals, 3);
  EXPECT_LE((a.states - b.states).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_LE((a.costs - b.costs).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_EQ(a.states.col(1), a.states.col(2));  // a step of length zero keeps the state
}

TEST(Simulate, StopsAtTheEndOfTheModel) {
  IntervalProblem problem;
  problem.arguments = {1, 0, 0};
  problem.dynamics = make_function<1, 0, 0>([](const auto&, const auto& x) { return x[0] * x[0]; });
  const auto integrator = cvodes()->make(problem);
  const VectorXd times = (VectorXd(4) << 0.0, 0.5, 2.0, 3.0).finished();
  const Simulation run =
      simulate(*integrator, VectorXd::Ones(1), times, MatrixXd(0, 3), VectorXd());
  EXPECT_NE(run.status, IntegrationStatus::success);
  EXPECT_EQ(run.intervals, 1);
  EXPECT_NEAR(run.states(0, 1), 2.0, 1e-7);
  EXPECT_TRUE(std::isnan(run.states(0, 2)));
}

TEST(Simulate, ChecksSizesAndTimes) {
  const auto integrator = cvodes()->make(affine_problem(InputShape::constant, false, false));
  const VectorXd x0 = VectorXd::Zero(3), p = VectorXd::Ones(2);
  const VectorXd back = (VectorXd(2) << 1.0, 0.5).finished();
  EXPECT_THROW(simulate(*integrator, x0, back, MatrixXd::Zero(2, 1), p), DefinitionError);
  const VectorXd times = (VectorXd(2) << 0.0, 0.5).finished();
  EXPECT_THROW(simulate(*integrator, x0, times, MatrixXd::Zero(2, 2), p), DefinitionError);
  EXPECT_THROW(simulate(*integrator, p, times, MatrixXd::Zero(2, 1), p), DefinitionError);
}

}  // namespace
}  // namespace saltus
