// A link from the last phase to the first: periodic trajectories, with and without a map between
// the ends, and jumps that change sizes.
#include <gtest/gtest.h>

#include <cmath>

#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "tests/support/point_mass.hpp"
#include "tests/support/program_derivatives.hpp"

namespace saltus {
namespace {

using testing_support::Ball;
using testing_support::gravity;

using testing_support::derivative_errors;
using testing_support::perturbed;

struct Forced {  // x'' = -x + cos(2 t) + u
  template <class S>
  Vec<S, 2> operator()(const S& t, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], cos(2.0 * t) + u[0] - x[0]};
  }
};

OptimalControlProblem oscillation() {
  Phase<2, 1> swing{"swing", Forced{}, exactly(M_PI)};
  swing.track(
      "effort", [](auto, auto, auto u) { return u; }, Vec<double, 1>{1.0});
  OptimalControlProblem ocp("oscillation");
  ocp.start_within({unbounded(), unbounded()}, Vec<double, 2>{1.0, 1.0}).then(swing);
  return ocp;
}

// With the period of the forcing and no effort, x = -cos(2 t) / 3 is the only periodic trajectory.
TEST(Closing, FindsAPeriodicTrajectory) {
  OptimalControlProblem ocp = oscillation();
  ocp.close();
  MultipleShooting shooting(ocp, {.intervals_per_phase = 20, .integrator = runge_kutta8()});
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-11}));
  ASSERT_TRUE(s.ok()) << s.message;
  for (const double t : {0.0, 0.3, 1.7, 3.0}) {
    EXPECT_NEAR(s.trajectory.state(t)[0], -std::cos(2.0 * t) / 3.0, 1e-9) << t;
    EXPECT_NEAR(s.trajectory.state(t)[1], 2.0 * std::sin(2.0 * t) / 3.0, 1e-9) << t;
  }
  EXPECT_NEAR(s.cost, 0.0, 1e-12);
}

struct Free {  // x'' = -x + u
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - x[0]};
  }
};

// After half a period of the undriven oscillator the state is x(T) = -x(0), so every start closes.
// With the map x -> -x + c, no start closes without input. The minimum effort for the offset c is u
// = A' G^-1 c.
TEST(Closing, AffineMapMinimisesTheEffort) {
  Phase<2, 1> swing{"swing", Free{}, exactly(M_PI)};
  swing.inputs(InputParametrisation::piecewise_linear).minimise("effort", [](auto, auto, auto u) {
    return 0.5 * u[0] * u[0];
  });
  OptimalControlProblem ocp("half a swing");
  ocp.start_within({between(-2.0, 2.0), between(-2.0, 2.0)}, Vec<double, 2>{1.0, 0.0});
  ocp.then(swing).costs(CostRule::integrated).close(jump<2>("mirror", [](auto, auto x) {
    return decltype(x){0.6 - x[0], -x[1]};
  }));
  // x(T) = -x0 + int_0^pi (sin(pi - s), cos(pi - s)) u(s) ds, so the integral is (0.6, 0): with the
  // Gramian pi/2 times the identity u = 0.6 sin(s) / (pi/2) and the cost is 1/2 0.6^2 / (pi/2).
  MultipleShooting shooting(ocp, {.intervals_per_phase = 40, .integrator = runge_kutta8()});
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-11}));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.cost, 0.18 / (0.5 * M_PI), 1e-6);  // ramps follow the sine to h^4 / 720 in the cost
  const VectorXd x0 = s.trajectory.state(0.0), x1 = s.trajectory.final_state();
  EXPECT_NEAR(x0[0], 0.6 - x1[0], 1e-9);
  EXPECT_NEAR(x0[1], -x1[1], 1e-9);
}

// A ball that hops periodically, with restitution e = 0.8. With k = 1 + 1/e, a hop of duration T
// and initial speed a costs ((g T)^2/2 - k g T a + (2 k^2 - 6 k + 6) a^2) / T. The optimal a is 3/7
// g T, and the hop then costs g^2 T / 56. A further cost of 1/T gives T = sqrt(56) / g.
OptimalControlProblem hopping() {
  constexpr double restitution = 0.8;
  Phase<2, 1> hop{"hop", Ball{}, between(0.1, 3.0)};
  hop.inputs(InputParametrisation::piecewise_linear_continuous)
      .minimise("effort", [](auto, auto, auto u) { return 0.5 * u[0] * u[0]; })
      .minimise_at_end("haste", [](auto t, auto) { return 1.0 / t; })
      .ends_when(
          "touch-down", [](auto, auto x) { return x[0]; }, Crossing::falling)
      .guess_duration(1.0)
      .guess_state(Guess::interpolate(Vec<double, 2>{0.0, 4.0}, Vec<double, 2>{0.0, -4.0}));
  OptimalControlProblem ocp("hopping");
  ocp.start_within({exactly(0.0), at_least(0.0)}, Vec<double, 2>{0.0, 4.0});
  ocp.then(hop).costs(CostRule::integrated).close(jump<2>("rebound", [](auto, auto x) {
    return decltype(x){x[0], -restitution * x[1]};
  }));
  return ocp;
}

void expect_hop(const Solution& s, double tolerance) {
  ASSERT_TRUE(s.ok()) << s.message;
  const double T = std::sqrt(56.0) / gravity;
  EXPECT_NEAR(s.durations[0], T, tolerance);
  EXPECT_NEAR(s.cost, 2.0 / T, tolerance);
  EXPECT_NEAR(s.trajectory.state(0.0)[1], 3.0 / 7.0 * gravity * T, tolerance);
  EXPECT_TRUE(s.crossings.front().is_as_declared());
}

TEST(Closing, FindsAPeriodicHop) {
  MultipleShooting shooting(hopping(), {.intervals_per_phase = 6, .integrator = runge_kutta4()});
  expect_hop(solve(shooting, *make_ipopt({.tolerance = 1e-11})), 1e-8);
}

// The stages carry the first state to the row that uses it.
TEST(Closing, IsSolvedByStages) {
  for (OptimalControlProblem ocp : {oscillation().close(), hopping()}) {
    MultipleShooting shooting(
        ocp, {.intervals_per_phase = 12, .integrator = runge_kutta4({.steps = 4})});
    const Solution by_stages =
        solve(shooting, *make_native_solver({.tolerance = 1e-9, .qp = riccati_qp()}));
    const Solution by_ipopt = solve(shooting, *make_ipopt({.tolerance = 1e-11}));
    ASSERT_TRUE(by_stages.ok()) << ocp.name() << ": " << by_stages.message;
    EXPECT_NEAR(by_stages.cost, by_ipopt.cost, 1e-8) << ocp.name();
  }
}

// A free start takes the value from the trajectory, a bounded start stays within its bounds, and a
// given start is unchanged.
TEST(Closing, GuessFromATrajectoryKeepsItsStart) {
  OptimalControlProblem ocp = oscillation();
  MultipleShooting shooting(ocp.close(), {.intervals_per_phase = 6, .integrator = runge_kutta8()});
  NlpPoint at = shooting.initial_guess();
  at.w[shooting.layout().state(0, 0)] = 0.7;
  const Trajectory trajectory = shooting.trajectory(at.w);
  EXPECT_EQ(shooting.guess_from(trajectory).w[shooting.layout().state(0, 0)], 0.7);
  ocp.start_within({between(0.0, 0.5), exactly(0.0)}, Vec<double, 2>{0.2, 0.0});
  MultipleShooting bounded(ocp, {.intervals_per_phase = 6, .integrator = runge_kutta8()});
  const NlpPoint guess = bounded.guess_from(trajectory);
  EXPECT_EQ(guess.w[bounded.layout().state(0, 0)], 0.5);
  EXPECT_EQ(guess.w[bounded.layout().state(0, 0) + 1], 0.0);
}

// The message names an infeasible closing link.
TEST(Closing, ImpossibleClosingIsNamed) {
  Phase<1, 1> drift{"drift", [](auto, auto, auto u) { return decltype(u)(u); }, exactly(1.0)};
  drift.bound_input(0, between(1.0, 2.0));
  OptimalControlProblem ocp("drift");
  ocp.start_within({between(-5.0, 5.0)}, Vec<double, 1>{0.0}).then(drift).close();
  MultipleShooting shooting(ocp, {.intervals_per_phase = 5, .integrator = runge_kutta4()});
  const Solution s = solve(shooting, *make_ipopt());
  EXPECT_EQ(s.status, SolveStatus::infeasible);
  EXPECT_NE(s.message.find("closing 'identity' from the end of phase 'drift'"), std::string::npos)
      << s.message;
}

// --- sizes that change --------------------------------------------------------------------------

struct Wide {  // 2 states, 1 input, an unknown
  template <class S>
  Vec<S, 2> operator()(const S& t, const Vec<S, 2>& x, const Vec<S, 1>& u,
                       const Vec<S, 1>& p) const {
    return {x[1] * sin(t), u[0] - p[0] * x[0]};
  }
};
struct Narrow {  // 1 state, 2 inputs, data and the same unknown
  template <class S>
  Vec<S, 1> operator()(const S& t, const Vec<S, 1>& x, const Vec<S, 2>& u,
                       const Vec<S, 2>& p) const {
    return Vec<S, 1>{u[0] * x[0] + u[1] * p[0] + p[1] * t};
  }
};

// Sizes differ. Both jumps depend on the free time and on the parameters of the phase that ends.
OptimalControlProblem changing_sizes() {
  Phase<2, 1, 1> wide{"wide", Wide{}, between(0.5, 2.0)};
  Phase<1, 2, 2> narrow{"narrow", Narrow{}, between(0.5, 2.0)};
  wide.unknown("stiffness", Vec<double, 1>{0.7}, between(0.0, 3.0), 2.0)
      .nominal(Vec<double, 2>{2.0, 3.0}, Vec<double, 1>{4.0})
      .guess_duration(1.0);
  narrow.data("load", Vec<double, 1>{0.4})
      .unknown("stiffness", Vec<double, 1>{0.7}, between(0.5, 4.0), 2.0)
      .nominal(Vec<double, 1>{5.0}, Vec<double, 2>{0.5, 2.0})
      .nominal_duration(0.3)
      .guess_duration(0.8);
  OptimalControlProblem ocp("changing sizes");
  ocp.start_within({unbounded(), unbounded()}, Vec<double, 2>{1.0, -1.0}).then(wide);
  ocp.then(narrow, jump<2, 1>("join", [](auto t, auto x, auto, auto p) {
             return x[0] * p[0] + x[1] * sin(t);
           }));
  ocp.close(jump<1, 2>("split", [](auto t, auto x, auto, auto p) {
    using S = std::decay_t<decltype(t)>;
    return Vec<S, 2>{x[0] * x[0] * p[1], p[0] * t + x[0]};
  }));
  return ocp;
}

TEST(ChangingSizes, HaveExactDerivatives) {
  MultipleShooting shooting(changing_sizes(),
                            {.intervals_per_phase = 3, .integrator = runge_kutta4()});
  EXPECT_EQ(shooting.layout().parameter(0, 0), shooting.layout().parameter(1, 1));
  EXPECT_EQ(shooting.layout().parameter(1, 0), -1);  // data
  for (const unsigned seed : {1u, 2u}) {
    const auto errors = derivative_errors(
        shooting.nlp(), perturbed(shooting.nlp(), shooting.initial_guess().w, seed, 0.1));
    EXPECT_LT(errors.jacobian, 1e-8) << seed;  // accuracy of central differences
    EXPECT_LT(errors.hessian, 1e-7) << seed;
  }
}

// The rows equal those of the jumps, x+ - g(t, x-, p), also after a change of time and data.
TEST(ChangingSizes, AreMappedByTheJumps) {
  MultipleShooting shooting(changing_sizes(),
                            {.intervals_per_phase = 3, .integrator = runge_kutta4()});
  shooting.start_time(0.25);
  shooting.set_data("load", Vec<double, 1>{-0.6});
  NlpPoint at = perturbed(shooting.nlp(), shooting.initial_guess().w, 5, 0.1);
  const Trajectory trajectory = shooting.trajectory(at.w);
  VectorXd g(shooting.nlp().rows());
  ASSERT_TRUE(shooting.nlp().constraints(at.w.data(), g.data()));
  const double T0 = at.w[shooting.layout().duration(0)];
  const double T1 = 0.3 * at.w[shooting.layout().duration(1)];
  const double p = 2.0 * at.w[shooting.layout().parameter(0, 0)];
  const VectorXd before = trajectory.state_before(0.25 + T0), x = trajectory.final_state();
  const double entered = 5.0 * at.w[shooting.layout().state(1, 0)], end = 0.25 + T0 + T1;
  const auto row = [&](const std::string& name) {
    for (int r = 0; r < shooting.nlp().rows(); ++r)
      if (shooting.nlp().describe_row(r).starts_with(name)) return r;
    ADD_FAILURE() << "there is no row '" << name << "'";
    return 0;
  };
  const double rounding = 1e-14;
  EXPECT_NEAR(g[row("jump 'join'")] * 5.0,
              entered - (before[0] * p + before[1] * std::sin(0.25 + T0)), rounding);
  const int closing = row("closing 'split' from the end of phase 'narrow'");
  const VectorXd start = trajectory.state(0.25);
  EXPECT_NEAR(g[closing] * 2.0, start[0] - x[0] * x[0] * p, rounding);
  EXPECT_NEAR(g[closing + 1] * 3.0, start[1] - (-0.6 * end + x[0]), rounding);
}

}  // namespace
}  // namespace saltus
