// Stiff dynamics in shooting: implicit Runge-Kutta in steps far beyond the fast time constants,
// with second derivatives, against CVODES at a tight tolerance.
#include <gtest/gtest.h>

#include <cmath>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/replay.hpp"

namespace saltus {
namespace {

// Van der Pol's oscillator with mu = 1e3: a time constant of one millisecond in a plan of 200 s.
struct Oscillator {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], 1e3 * (1.0 - x[0] * x[0]) * x[1] - x[0] + u[0]};
  }
};

OptimalControlProblem oscillator() {
  Phase<2, 1> phase{"slow branch", Oscillator{}, exactly(200.0)};
  phase
      .minimise("deviation",
                [](const auto&, const auto& x, const auto& u) {
                  return (x[0] - 2.2) * (x[0] - 2.2) + 0.01 * u[0] * u[0];
                })
      .nominal(Vec<double, 2>{1.0, 1e-3}, Vec<double, 1>{1.0})
      .guess_state(Guess::constant(Vec<double, 2>{2.0, 0.0}));
  OptimalControlProblem ocp("stiff oscillator");
  ocp.start_at({2.0, -2.0 / 3e3}).then(phase).costs(CostRule::integrated);
  return ocp;
}

// A batch reactor. A and B reach equilibrium within microseconds, B becomes the product C, and two
// B become waste. Heat accelerates both reactions and shifts the equilibrium.
struct Reactor {
  template <class S>
  Vec<S, 3> operator()(const S&, const Vec<S, 3>& x, const Vec<S, 1>& u) const {
    const S exchange = 1e6 * (x[0] - exp(0.5 * u[0]) * x[1]);
    const S product = exp(u[0]) * x[1], waste = exp(2.5 * u[0]) * x[1] * x[1];
    return {-exchange, exchange - product - 2.0 * waste, product};
  }
};

OptimalControlProblem reactor() {
  Phase<3, 1> phase{"batch", Reactor{}, exactly(2.0)};
  phase.minimise_at_end("yield", [](const auto&, const auto& x) { return -x[2]; })
      .minimise("heat", [](const auto&, const auto&, const auto& u) { return 0.01 * u[0] * u[0]; })
      .bound_input(0, between(-2.0, 2.0))
      .guess_state(Guess::simulate());
  OptimalControlProblem ocp("batch reactor");
  ocp.start_at({1.0, 0.0, 0.0}).then(phase).costs(CostRule::integrated);
  return ocp;
}

Solution solved(const OptimalControlProblem& ocp, const IntegratorChoice& integrator,
                Solver& solver) {
  MultipleShooting shooting(ocp, {.intervals_per_phase = 10, .integrator = integrator});
  return solve(shooting, solver);
}

void expect_the_optimum_of_cvodes(const OptimalControlProblem& ocp,
                                  const IntegratorChoice& integrator, double accuracy) {
  const auto ipopt = make_ipopt({.tolerance = 1e-9});
  const Solution plan = solved(ocp, integrator, *ipopt);
  ASSERT_TRUE(plan.ok()) << plan.message;
  EXPECT_NE(plan.curvature, OptimumCheck::Curvature::unknown);
  const IntegratorChoice reference = cvodes({.tolerance = 1e-12, .absolute_tolerance = 1e-14});
  const Solution adaptive = solved(ocp, reference, *make_ipopt({.tolerance = 1e-7}));
  EXPECT_NEAR(plan.cost, adaptive.cost, accuracy * std::abs(adaptive.cost)) << adaptive.message;
  EXPECT_LE(replay(ocp, plan.trajectory, reference).from_start, accuracy);
  std::printf("cost %.12g vs %.12g  iterations %d %d replay %g integ %g\n", plan.cost,
              adaptive.cost, plan.iterations, adaptive.iterations,
              replay(ocp, plan.trajectory, reference).from_start, plan.verification->defect.sum);
  for (const SolverChoice name : {SolverChoice::sparse, SolverChoice::riccati}) {
    const Solution own = solved(ocp, integrator, *make_solver(name));
    EXPECT_TRUE(own.ok()) << own.message;
    EXPECT_NEAR(own.cost, plan.cost, 1e-7 * std::abs(plan.cost)) << name_of(name);
  }
}

TEST(StiffShooting, SolvesVanDerPolWithMu1000) {
  expect_the_optimum_of_cvodes(oscillator(), radau_iia({.stages = 3, .steps = 4}), 1e-7);
  const Solution explicit_plan =
      solved(oscillator(), runge_kutta8({.steps = 100}), *make_ipopt({.tolerance = 1e-7}));
  EXPECT_FALSE(explicit_plan.ok());
}

TEST(StiffShooting, SolvesABatchReactorWithAFastEquilibrium) {
  expect_the_optimum_of_cvodes(reactor(), radau_iia({.stages = 3, .steps = 4}), 1e-7);
}

}  // namespace
}  // namespace saltus
