// Integrals, links between the ends of any phases, a free start time, and soft limits. The
// derivatives of the whole program are exact, all solvers find the known optimum, and messages name
// the mistakes.
#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <type_traits>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/integrators/sundials.hpp"
#include "saltus/solver/ipopt.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "saltus/transcription/optimum_derivatives.hpp"
#include "tests/support/errors.hpp"
#include "tests/support/program_derivatives.hpp"

namespace saltus {
namespace {

using testing_support::derivative_errors;
using testing_support::perturbed;

struct Swing {  // depends on time, nonlinear, with an unknown
  template <class S>
  Vec<S, 2> operator()(const S& t, const Vec<S, 2>& x, const Vec<S, 1>& u,
                       const Vec<S, 1>& p) const {
    using std::cos, std::sin;
    return {x[1], u[0] * cos(t) - p[0] * sin(x[0]) + t};
  }
};
struct Velocity {
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>&, const Vec<S, 1>& u) const {
    return u;
  }
};
const auto first_state = [](const auto&, const auto& x) { return x[0]; };
const auto effort = [](const auto&, const auto&, const auto& u) { return u[0] * u[0]; };
const auto work = [](const auto& t, const auto& x, const auto& u, const auto& p) {
  return u[0] * x[1] + p[0] * t * t * x[0];
};

// All features together: an integral that skips a phase; links of times, durations, states and
// parameters, some of them soft; and a free start.
OptimalControlProblem everything(CostRule rule) {
  Phase<2, 1, 1> first{"first", Swing{}, between(0.3, 2.0)};
  Phase<2, 1, 1> second{"second", Swing{}, exactly(0.4)};
  Phase<2, 1, 1> third{"third", Swing{}, between(0.3, 2.0)};
  for (auto* phase : {&first, &second, &third})
    phase->unknown("stiffness", Vec<double, 1>{0.8}, between(0.1, 3.0))
        .minimise("cost", effort)
        .guess_duration(phase == &second ? 0.4 : 0.7);
  first.bound_integral("work", work, {at_most(0.3), huber("work", 2.0, 0.1)}, 0.5);
  third.bound_integral("work", work, between(-2.0, 1.0), 0.5)
      .bound_integral("other", work, {at_most(0.1), soft("other", 3.0, Penalty::L2)})
      .begin_with("start", first_state, at_most(0.1), soft("start", 1.5))
      .bound_state(1, at_most(0.2), {}, soft("speed", 0.7, Penalty::L2))
      .bound_input(0, between(-0.1, 0.1), {}, huber("thrust", 1.0, 0.2));
  OptimalControlProblem ocp("everything");
  ocp.start_within({unbounded(), unbounded()}, Vec<double, 2>{0.4, 0.1})
      .start_time(between(-1.0, 1.0), 0.2)
      .then(first)
      .then(second)
      .then(third)
      .costs(rule)
      .total_time(between(1.0, 3.0));
  ocp.link(
      "mixed",
      [](const auto& a, const auto& b, const auto& c) {
        auto rows = a.x.eval();
        rows[0] = a.x[0] * c.x[1] + a.t * b.duration;
        rows[1] = a.p[0] * b.x[0] - c.duration * c.t;
        return rows;
      },
      {{between(-3.0, 3.0), at_most(5.0)}}, start_of(first), end_of(second), end_of(third));
  ocp.link(
      "soft", [](const auto& a, const auto& b) { return a.duration * b.x[0] * b.x[0]; },
      {exactly(0.1), soft("soft link", 0.4)}, end_of(third), start_of(first));
  ocp.minimise_link(
      "cost",
      [](const auto& a, const auto& b) { return 0.1 * cosh(a.x[0] - b.x[1]) * b.duration + a.t; },
      start_of(second), end_of(third));
  return ocp;
}

TEST(Links, AllDerivativesAreExact) {
  for (const CostRule rule : {CostRule::nodes, CostRule::integrated}) {
    MultipleShooting shooting(everything(rule),
                              {.intervals_per_phase = 3, .integrator = runge_kutta4()});
    const NlpPoint point = perturbed(shooting.nlp(), shooting.initial_guess().w, 3);
    const auto errors = derivative_errors(shooting.nlp(), point);
    EXPECT_LT(errors.gradient, 1e-8);  // rounding of differences of steps of 1e-5
    EXPECT_LT(errors.jacobian, 1e-8);
    EXPECT_LT(errors.hessian, 1e-8);
  }
}

TEST(Links, AllSolversFindTheSameOptimum) {
  for (const CostRule rule : {CostRule::nodes, CostRule::integrated}) {
    MultipleShooting shooting(everything(rule),
                              {.intervals_per_phase = 6, .integrator = runge_kutta4()});
    const Solution reference = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
    ASSERT_TRUE(reference.ok()) << reference.message;
    for (const SolverChoice choice : {SolverChoice::sparse, SolverChoice::riccati}) {
      const Solution own = solve(shooting, *make_solver(choice, {.tolerance = 1e-9}));
      EXPECT_TRUE(own.ok()) << name_of(choice) << ": " << own.message;
      EXPECT_NEAR(own.cost, reference.cost, 1e-7) << name_of(choice);
    }
  }
}

// The ends are x1 and x2. Their cost is (x1^2 + (x2 - x1)^2) / 2 + exp(-x1 - x2) - 7, so the
// optimum has x2 - x1 = e, x1 = 2 e and e = exp(-5 e).
TEST(Links, MayBeAnyCost) {
  const auto half = [](const auto&, const auto&, const auto& u) { return 0.5 * u[0] * u[0]; };
  Phase<1, 1> a{"a", Velocity{}, exactly(1.0)}, b{"b", Velocity{}, exactly(1.0)};
  a.minimise("effort", half);
  b.minimise("effort", half);
  OptimalControlProblem ocp("cost of ends");
  ocp.start_at({0}).then(a).then(b);
  ocp.minimise_link(
      "late", [](const auto& x, const auto& y) { return exp(-x.x[0] - y.x[0]) - 7.0; }, end_of(a),
      end_of(b));
  double e = 0.3;
  for (int i = 0; i < 50; ++i) e -= (e - std::exp(-5.0 * e)) / (1.0 + 5.0 * std::exp(-5.0 * e));
  for (const SolverChoice choice :
       {SolverChoice::ipopt, SolverChoice::sparse, SolverChoice::riccati}) {
    MultipleShooting shooting(ocp, {.intervals_per_phase = 4, .integrator = runge_kutta4()});
    const Solution s = solve(shooting, *make_solver(choice, {.tolerance = 1e-10}));
    ASSERT_TRUE(s.ok()) << name_of(choice) << ": " << s.message;
    EXPECT_NEAR(s.trajectory.pieces()[3].end_state[0], 2.0 * e, 1e-7) << name_of(choice);
    EXPECT_NEAR(s.cost, 2.5 * e * e + e - 7.0, 1e-9) << name_of(choice);
    ASSERT_EQ(s.costs.size(), 3u);
    EXPECT_EQ(s.costs[2].term, "late");
    EXPECT_NEAR(s.costs[2].value, e - 7.0, 1e-7) << name_of(choice);
  }
}

// An integral continues from the value of an earlier phase with the same name.
TEST(Integral, ContinuesOverPhases) {
  Phase<1, 1> first{"first", Velocity{}, exactly(1.0)}, second{"second", Velocity{}, exactly(1.0)};
  first.minimise("effort", effort).bound_integral("distance", first_state, at_most(100.0));
  second.minimise("effort", effort).bound_integral("distance", first_state, exactly(3.0));
  OptimalControlProblem ocp("integral");
  ocp.start_at({1}).then(first).then(second);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  ASSERT_TRUE(s.ok()) << s.message;
  double distance = 0.0;  // for a speed that is linear in each interval
  for (const Trajectory::Piece& p : s.trajectory.pieces())
    distance += 0.5 * p.length * (p.state[0] + p.end_state[0]);
  EXPECT_NEAR(distance, 3.0, 1e-8);
}

// The reported value is the integral along the plan, also in the guess.
TEST(Integral, MatchesTheSumAlongThePlan) {
  Phase<1, 1> phase{"push", Velocity{}, exactly(2.0)};
  phase.minimise("effort", effort).bound_integral("distance", first_state, exactly(3.0));
  OptimalControlProblem ocp("integral");
  ocp.start_at({1}).then(phase).costs(CostRule::integrated);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 200, .integrator = runge_kutta4()});
  const int end = shooting.layout().integral(0, 200);
  // The guess stays at its start: two seconds at 1.
  EXPECT_NEAR(shooting.initial_guess().w[end], 2.0, 1e-12);
  const Solution s = solve(shooting, *make_solver(SolverChoice::riccati, {.tolerance = 1e-10}));
  ASSERT_TRUE(s.ok()) << s.message;
  ASSERT_EQ(s.integrals.size(), 1u);
  EXPECT_NEAR(s.integrals[0].value, 3.0, 1e-8);
  // x = 1 + c (2 t - t^2 / 2) with c = 3/8 and u = c (2 - t). The cost is c^2 8/3. Piecewise
  // constant inputs add h^2 / 12 of the squared slope over two seconds.
  EXPECT_NEAR(s.cost, 9.0 / 64.0 * 8.0 / 3.0, 9.0 / 64.0 * 2.0 * 1e-4 / 12.0 * 1.1);
}

TEST(Integral, WorksWithIntegratorsWithoutSecondDerivatives) {
  Phase<1, 1> phase{"push", Velocity{}, exactly(1.0)};
  phase.minimise("effort", effort)
      .bound_integral("effort used", effort, at_most(0.25))
      .minimise_at_end("short of one", [](const auto&, const auto& x) { return -4.0 * x[0]; });
  OptimalControlProblem ocp("budget");
  ocp.start_at({0}).then(phase);
  for (const IntegratorChoice& integrator : {runge_kutta4(), cvodes({.tolerance = 1e-10})}) {
    MultipleShooting shooting(ocp, {.intervals_per_phase = 5, .integrator = integrator});
    const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-9}));
    ASSERT_TRUE(s.ok()) << s.message;
    EXPECT_NEAR(s.cost, 0.25 - 2.0, 1e-7);  // u = 1/2
  }
}

// The message names an infeasible term.
TEST(Integral, InfeasibleIntegralAndLinkAreNamed) {
  Phase<1, 1> phase{"push", Velocity{}, exactly(1.0)};
  phase.minimise("effort", effort)
      .bound_integral("effort used", effort, at_most(0.25))
      .reach("far", first_state, exactly(2.0));
  OptimalControlProblem ocp("too far");
  ocp.start_at({0}).then(phase);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 5, .integrator = runge_kutta4()});
  const Solution s = solve(shooting, *make_solver(SolverChoice::sparse));
  EXPECT_EQ(s.status, SolveStatus::infeasible);
  EXPECT_NE(s.message.find("integral 'effort used'"), std::string::npos) << s.message;

  Phase<1, 1> bounded{"bounded", Velocity{}, exactly(1.0)};
  bounded.minimise("effort", effort).bound_input(0, between(-1.0, 1.0));
  OptimalControlProblem apart("apart");
  apart.start_at({0}).then(bounded);
  apart.link(
      "twice as far", [](const auto& a, const auto& b) { return b.x[0] - a.x[0]; }, exactly(2.0),
      start_of(bounded), end_of(bounded));
  MultipleShooting linked(apart, {.intervals_per_phase = 5, .integrator = runge_kutta4()});
  const Solution none = solve(linked, *make_solver(SolverChoice::sparse));
  EXPECT_FALSE(none.ok());
  EXPECT_NE(none.message.find("link 'twice as far'"), std::string::npos) << none.message;
}

std::string complaint(const OptimalControlProblem& ocp) {
  return error_of<DefinitionError>([&] { ocp.check(); }, "");
}

#define EXPECT_SAYS(text, part) EXPECT_NE((text).find(part), std::string::npos) << (text)

TEST(Links, RejectsInvalidLinksByName) {
  Phase<1, 1> a{"a", Velocity{}, exactly(1.0)}, b{"b", Velocity{}, exactly(1.0)},
      elsewhere{"bb", Velocity{}, exactly(1.0)};
  const auto gap = [](const auto& x, const auto& y) { return x.x[0] - y.x[0]; };
  const auto problem = [&] {
    OptimalControlProblem ocp("bad");
    ocp.start_at({0}).then(a).then(b);
    return ocp;
  };
  EXPECT_EQ(complaint(problem().link("gap", gap, exactly(0.0), start_of(a), end_of(b))), "");
  EXPECT_SAYS(complaint(problem().link("gap", gap, exactly(0.0), start_of(a), end_of(elsewhere))),
              "problem 'bad', link 'gap': there is no phase 'bb'; did you mean 'b'?");
  EXPECT_SAYS(complaint(problem().then(a).link("gap", gap, exactly(0.0), start_of(a), end_of(b))),
              "2 phases are called 'a'");
  EXPECT_SAYS(complaint(problem().link("gap", gap, between(1.0, 0.0), start_of(a), end_of(b))),
              "link 'gap': the bounds [1, 0] of row 0 are empty");
  EXPECT_SAYS(
      complaint(problem().link("gap", gap, {{exactly(0.0), exactly(0.0)}}, start_of(a), end_of(b))),
      "the formula has 1 rows, but 2 bounds were given");
  EXPECT_SAYS(complaint(problem().link("gap", gap, {exactly(0.0), soft("gap", -1.0)}, start_of(a),
                                       end_of(b))),
              "the penalty weight 'gap' is -1");
  EXPECT_SAYS(complaint(problem()
                            .link("gap", gap, exactly(0.0), start_of(a), end_of(b))
                            .link("gap", gap, exactly(0.0), start_of(a), end_of(b))),
              "there are two links with this name");
  const auto two_rows = [](const auto& x, const auto&) {
    return Vec<std::decay_t<decltype(x.t)>, 2>{x.t, x.duration};
  };
  EXPECT_SAYS(complaint(problem().minimise_link("gap", two_rows, start_of(a), end_of(b))),
              "link 'gap': a cost must be a scalar, but the formula has 2 rows");
  EXPECT_SAYS(complaint(problem().start_time(between(0.0, 1.0), 2.0)),
              "the guess of the start time, 2 s, lies outside its bounds [0, 1] s");
}

TEST(Integral, RejectsInvalidIntegralsByName) {
  const auto problem = [](const Phase<1, 1>& phase) {
    OptimalControlProblem ocp("bad");
    ocp.start_at({0}).then(phase);
    return ocp;
  };
  const auto phase = [] { return Phase<1, 1>{"push", Velocity{}, exactly(1.0)}; };
  EXPECT_SAYS(complaint(problem(phase().bound_integral(
                  "state", [](const auto&, const auto& x) { return x; }, between(2.0, 1.0)))),
              "phase 'push': integral 'state': the bounds [2, 1] are empty");
  EXPECT_SAYS(complaint(problem(phase().bound_integral("effort", effort, at_most(1.0), 0.0))),
              "integral 'effort': its magnitude is 0, expected a positive number");
  EXPECT_SAYS(
      complaint(problem(
          phase().minimise("effort", effort).bound_integral("effort", effort, at_most(1.0)))),
      "two terms are called 'effort'");
  const Phase<1, 1> one = phase().bound_integral("effort", effort, at_most(1.0), 1.0),
                    other = phase().bound_integral("effort", effort, at_most(1.0), 2.0);
  EXPECT_SAYS(complaint(problem(one).then(other)),
              "integral 'effort' continues from phase 'push', where its magnitude is 1, not 2");
  expect_error<DefinitionError>([&] { problem(one).then(one).after(1); },
                                {"integral 'effort' continues from removed phases"});
  Phase<1, 1> push = phase();
  expect_error<DefinitionError>([&] { push.bound_state(3, at_most(1.0), {}, soft("w", 1.0)); },
                                {"phase 'push': there is no state 3; the phase has 1"});
}

// A penalty weight of a link changes between solves.
TEST(Links, WeightsCanChange) {
  Phase<1, 1> pull{"pull", Velocity{}, exactly(1.0)};
  pull.minimise("effort",
                [](const auto&, const auto&, const auto& u) { return 0.5 * u[0] * u[0]; });
  OptimalControlProblem ocp("weight");
  ocp.start_at({0}).then(pull);
  ocp.link(
      "near one", [](const auto& end) { return end.x[0]; }, {at_least(1.0), soft("near", 0.25)},
      end_of(pull));
  MultipleShooting shooting(ocp, {.intervals_per_phase = 4, .integrator = runge_kutta4()});
  const auto solver = make_solver(SolverChoice::sparse, {.tolerance = 1e-10});
  for (const double weight : {0.25, 0.5, 2.0}) {
    shooting.set_penalty_weight("near", weight);
    const double reached = std::min(weight, 1.0);
    const Solution s = solve(shooting, *solver);
    ASSERT_TRUE(s.ok()) << s.message;
    EXPECT_NEAR(s.cost, 0.5 * reached * reached + weight * (1.0 - reached), 1e-8);
    ASSERT_EQ(s.soft_violations.size(), 1u);
    EXPECT_NEAR(s.soft_violations[0].largest, 1.0 - reached, 1e-7);
    EXPECT_DOUBLE_EQ(s.soft_violations[0].time, 1.0);
  }
}

// The result does not depend on units: an integral of thousands, with and without a declared
// magnitude.
TEST(Integral, IsIndependentOfMagnitude) {
  for (const double magnitude : {1.0, 5e4})
    for (const SolverChoice choice :
         {SolverChoice::ipopt, SolverChoice::sparse, SolverChoice::riccati}) {
      Phase<1, 1> phase{"push", Velocity{}, exactly(1.0)};
      phase.minimise("effort", effort)
          .bound_integral(
              "way", [](const auto&, const auto&, const auto& u) { return 1e5 * u[0]; },
              at_least(5e4), magnitude);
      OptimalControlProblem ocp("units");
      ocp.start_at({0}).then(phase);
      MultipleShooting shooting(ocp, {.intervals_per_phase = 8, .integrator = runge_kutta4()});
      const Solution s = solve(shooting, *make_solver(choice));
      EXPECT_TRUE(s.ok()) << name_of(choice) << ": " << s.message;
      EXPECT_NEAR(s.cost, 0.25, 1e-6) << name_of(choice);
    }
}

// The derivative with respect to a held start time equals that of the closed form.
TEST(FreeStart, IsTreatedLikeAFreeDuration) {
  Phase<1, 1> crossing{"crossing",
                       [](const auto& t, const auto&, const auto& u) { return u[0] + cos(t); },
                       exactly(1.0)};
  crossing.minimise("effort", effort).reach("shore", first_state, exactly(2.0));
  OptimalControlProblem ocp("tide");
  ocp.start_at({0}).start_time(between(0.0, 2.0), 0.5).then(crossing);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 8, .integrator = runge_kutta8()});
  const Solution s = solve(shooting, *make_ipopt({.tolerance = 1e-10}));
  ASSERT_TRUE(s.ok()) << s.message;
  EXPECT_NEAR(s.trajectory.start_time(), 0.0, 1e-7);  // the earliest is the nearest to -1/2
  const double left = 2.0 - std::sin(1.0);
  EXPECT_NEAR(s.cost, left * left, 1e-7);
  OptimumDerivatives derivatives(shooting, s);
  EXPECT_NEAR(derivatives.wrt_start_time().cost, -2.0 * left * (std::cos(1.0) - 1.0), 1e-6);
  // A guess from a plan takes the time of the plan.
  EXPECT_NEAR(shooting.guess_from(s.trajectory).w[shooting.layout().start_time()], 0.0, 1e-7);
}

}  // namespace
}  // namespace saltus
