// Errors that a program does not detect in its own solution: constraints thinner than an interval,
// and the integration error. Status and message report them, and refinement corrects them.
#include <gtest/gtest.h>

#include <cmath>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/between_nodes.hpp"
#include "saltus/transcription/replay.hpp"

namespace saltus {
namespace {

std::unique_ptr<Solver> ipopt() { return make_ipopt({.tolerance = 1e-9}); }

// ---- the Alp rider: four peaks, of which the last is 1 s wide
// ----------------------------------------

struct Rider {
  template <class S>
  Vec<S, 4> operator()(const S&, const Vec<S, 4>& x, const Vec<S, 2>& u) const {
    return {-10.0 * x[0] + u[0] + u[1], -2.0 * x[1] + u[0] + 2.0 * u[1],
            -3.0 * x[2] + 5.0 * x[3] + u[0] - u[1], 5.0 * x[2] - 3.0 * x[3] + u[0] + 3.0 * u[1]};
  }
};
// |x|^2 must be above the terrain.
const auto height_above = [](auto t, auto x) {
  using std::exp;
  const auto peak = [&](double a, double b) { return exp(-b * (t - a) * (t - a)); };
  return x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3] - 3.0 * peak(3, 12) -
         3.0 * peak(6, 10) - 3.0 * peak(10, 6) - 8.0 * peak(15, 4);
};

OptimalControlProblem alp_rider(double allowed = 0.0) {
  Phase<4, 2> phase{"ride", Rider{}, exactly(20.0)};
  phase.minimise("effort", [](auto, auto x, auto u) {
    return 100.0 * (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] + x[3] * x[3]) +
           0.01 * (u[0] * u[0] + u[1] * u[1]);
  });
  phase.keep("above the terrain", height_above, at_least(0.01));
  if (allowed > 0.0) phase.allow("above the terrain", allowed);
  for (int i = 0; i < 4; ++i)
    phase.reach(
        "end " + std::to_string(i), [i](auto, auto x) { return x[i]; },
        exactly(std::array{2.0, 3.0, 1.0, -2.0}[i]));
  OptimalControlProblem ocp("Alp rider");
  ocp.start_at({2, 1, 2, 1}).then(phase).costs(CostRule::integrated);
  return ocp;
}

TEST(ThinConstraint, PassedBetweenNodesIsNotAnOptimum) {
  MultipleShooting shooting(alp_rider(),
                            {.intervals_per_phase = 100, .integrator = runge_kutta4({.steps = 4})});
  const Solution s = solve(shooting, *make_ipopt());
  EXPECT_LT(s.cost, 1900.0);  // 2031 is correct
  EXPECT_FALSE(s.ok());
  EXPECT_EQ(s.status, SolveStatus::coarse_grid);
  EXPECT_GT(s.verification->between_nodes.amount, 1.0);
  EXPECT_NE(s.message.find("'above the terrain' of phase 'ride'"), std::string::npos) << s.message;
  EXPECT_NE(s.message.find("solve_refined"), std::string::npos) << s.message;
}

// With free refined inputs the plan would pass between the nodes of the next finer mesh. With held
// inputs it does not, and the optimum is that of 100 intervals (2460; with 200 it is 2178, with 400
// 2085).
TEST(ThinConstraint, RefinementStopsTunnelling) {
  const RefinedSolution r = solve_refined(alp_rider(1e-2),
                                          {.intervals_per_phase = 100,
                                           .integrator = runge_kutta4({.steps = 4}),
                                           .accuracy = {.defect = 1e-2, .cost = 1e-3}},
                                          *ipopt(), {.tolerance = 1e-2, .integration = 0.1});
  EXPECT_TRUE(r.reached) << r.message;
  EXPECT_TRUE(r.solution.ok()) << r.solution.message;
  EXPECT_LE(r.solution.verification->between_nodes.amount, 1e-2);
  EXPECT_NEAR(r.solution.cost, 2460.0, 10.0) << r.message;
  EXPECT_EQ(r.shooting.options().meshes[0].input_intervals().size(), 100u);
}

// ---- integration
// ---------------------------------------------------------------------------------

struct Pendulum {  // x = (angle rad, rate rad/s), u = torque per inertia
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    using std::sin;
    return {x[1], -9.81 * sin(x[0]) + u[0]};
  }
};

OptimalControlProblem pendulum() {
  Phase<2, 1> phase{"swing", Pendulum{}, exactly(4.0)};
  phase.bound_input(0, between(-6.0, 6.0))
      .minimise("effort", [](auto, auto, auto u) { return 0.5 * u[0] * u[0]; })
      .reach(
          "up", [](auto, auto x) { return x[0]; }, exactly(3.14159265358979))
      .reach(
          "at rest", [](auto, auto x) { return x[1]; }, exactly(0.0));
  OptimalControlProblem ocp("pendulum");
  ocp.start_at({0, 0}).then(phase).costs(CostRule::integrated);
  return ocp;
}

TEST(IntegrationError, IsReportedForACoarseGrid) {
  MultipleShooting shooting(pendulum(), {.intervals_per_phase = 8, .integrator = runge_kutta4()});
  const Solution s = solve(shooting, *make_ipopt());
  EXPECT_EQ(s.status, SolveStatus::coarse_grid) << s.message;
  ASSERT_TRUE(s.verification.has_value());
  EXPECT_GT(s.verification->defect.sum, 1e-3);
  EXPECT_NE(s.message.find(" error of "), std::string::npos) << s.message;
  // CVODES finds the same error in each interval.
  const ReplayReport truth = replay(shooting.problem(), s.trajectory, cvodes({.tolerance = 1e-12}));
  EXPECT_NEAR(s.verification->defect.largest, truth.from_nodes, 1e-3 * truth.from_nodes);
}

// x' = -lambda (x - u): Runge-Kutta of order 4 with steps of 1/30 s is stable up to lambda = 83.
TEST(IntegrationError, PreventsTheStatusOptimal) {
  for (const double lambda : {1.0, 200.0}) {
    Phase<1, 1> phase{
        "stiff", [lambda](auto, auto x, auto u) { return decltype(x){-lambda * (x[0] - u[0])}; },
        exactly(2.0)};
    phase.bound_input(0, between(-1.0, 1.0))
        .track(
            "follow", [](auto t, auto x) { return x[0] - sin(t); }, VectorXd::Ones(1));
    OptimalControlProblem ocp("stiff");
    MultipleShooting shooting(
        ocp.start_at({1.0}).then(phase),
        {.intervals_per_phase = 30, .integrator = runge_kutta4({.steps = 2})});
    const Solution s = solve(shooting, *make_ipopt());
    ASSERT_TRUE(s.verification.has_value());
    const bool is_far_off = lambda > 100.0;
    EXPECT_EQ(s.verification->defect.largest > GridAccuracy{}.defect, is_far_off);
    EXPECT_EQ(s.ok(), !is_far_off) << s.message;
  }
}

// States of 1e-6 have the same relative error as states of 1.
TEST(IntegrationError, IsRelativeToSmallStates) {
  std::vector<double> missed, estimated;
  for (const double unit : {1.0, 1e-6}) {
    Phase<1, 1> phase{"decay", [](auto, auto x, auto u) { return decltype(x){-4.0 * x[0] + u[0]}; },
                      exactly(1.0)};
    phase.minimise("effort", [](auto, auto, auto u) { return u[0] * u[0]; });
    OptimalControlProblem ocp("decay");
    MultipleShooting shooting(ocp.start_at({unit}).then(phase),
                              {.intervals_per_phase = 2, .integrator = runge_kutta4()});
    const Solution s = solve(shooting, *make_ipopt());
    ASSERT_TRUE(s.verification.has_value());
    estimated.push_back(s.verification->defect.largest);
    missed.push_back(replay(ocp, s.trajectory, cvodes({.tolerance = 1e-11})).from_nodes);
  }
  EXPECT_GT(missed[0], 0.1);
  EXPECT_NEAR(missed[1], missed[0], 1e-3 * missed[0]);
  EXPECT_GT(estimated[0], 0.1);
  EXPECT_NEAR(estimated[1], estimated[0], 1e-3 * estimated[0]);
}

// x' = +-(x_1, x_0). The flow consists of cosh and sinh, and the angle between its columns
// decreases or increases.
TEST(Replay, ReportsTheGrowthOfTheFlow) {
  for (const double sign : {1.0, -1.0}) {
    Phase<2, 1> phase{"pair",
                      [sign](const auto&, const auto& x, const auto& u) {
                        return std::decay_t<decltype(x)>{sign * x[1] + u[0], sign * x[0]};
                      },
                      exactly(2.0)};
    phase.minimise("effort", [](auto, auto, auto u) { return u[0] * u[0]; });
    OptimalControlProblem ocp("pair");
    ocp.start_at({0.1, 0.2}).then(phase);
    MultipleShooting shooting(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
    const Solution s = solve(shooting, *make_ipopt());
    ASSERT_TRUE(s.ok()) << s.message;
    const ReplayReport report = replay(ocp, s.trajectory, cvodes({.tolerance = 1e-11}));
    EXPECT_TRUE(report.completed);
    EXPECT_NEAR(report.flow_growth, std::exp(2.0), 1e-8);
  }
}

TEST(IntegrationError, IsSmallOnAFineGrid) {
  MultipleShooting fine(pendulum(),
                        {.intervals_per_phase = 80, .integrator = runge_kutta4({.steps = 4})});
  const Solution s = solve(fine, *make_ipopt());
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_LT(s.verification->defect.sum, 1e-6);
  EXPECT_EQ(s.message.find(" error of "), std::string::npos) << s.message;
  MultipleShooting adaptive(pendulum(),
                            {.intervals_per_phase = 20, .integrator = cvodes({.tolerance = 1e-9})});
  const Solution a = solve(adaptive, *make_ipopt({.tolerance = 1e-6}));
  ASSERT_TRUE(a.ok()) << a.message;
  EXPECT_LT(a.verification->defect.sum, 1e-4);
  EXPECT_GT(a.verification->defect.sum, 1e-12);
}

TEST(IntegrationError, IsReducedByRefinement) {
  const RefinedSolution r =
      solve_refined(pendulum(), {.intervals_per_phase = 8, .integrator = runge_kutta4()}, *ipopt(),
                    {.integration = 1e-4});
  EXPECT_TRUE(r.reached) << r.message;
  EXPECT_LE(r.solution.verification->defect.sum, 1e-4);
  EXPECT_GT(r.intervals.front(), 8);
  const RefinedSolution limited =
      solve_refined(pendulum(), {.intervals_per_phase = 8, .integrator = runge_kutta4()}, *ipopt(),
                    {.integration = 1e-4, .rounds = 1});
  EXPECT_FALSE(limited.reached);
  EXPECT_NE(limited.message.find("integration error is"), std::string::npos) << limited.message;
}

}  // namespace
}  // namespace saltus
