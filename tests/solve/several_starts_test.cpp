// Several starts and homotopy. Several starts give distinct optima in an order that is independent
// of threads. Homotopy solves a problem that its own guess does not solve.
#include "saltus/solve/solve.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "saltus/core/error.hpp"
#include "saltus/integrators/runge_kutta.hpp"
#include "saltus/solver/native_solver.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

// A ball with x' = u, |u| <= 3 s^-1 for 1 s, and the end cost (x^2 - 1)^2 + x / 4. The valley at -1
// is deeper than the one at 1.
OptimalControlProblem valleys() {
  Phase<1, 1> roll{
      "roll", [](const auto&, const auto&, const auto& u) { return std::decay_t<decltype(u)>{u}; },
      exactly(1.0)};
  roll.bound_input(0, between(-3.0, 3.0))
      .minimise_at_end("valley",
                       [](const auto&, const auto& x) {
                         return (x[0] * x[0] - 1.0) * (x[0] * x[0] - 1.0) + 0.25 * x[0];
                       })
      .minimise("effort",
                [](const auto&, const auto&, const auto& u) { return 1e-3 * u[0] * u[0]; });
  OptimalControlProblem ocp("valleys");
  ocp.start_at({0.0}).then(roll);
  return ocp;
}

SeveralSolutions::Start towards(double end) {
  const auto at = [](double x) { return VectorXd(Vec<double, 1>(x)); };
  return {.states = {Guess::interpolate(at(0.0), at(end))}, .inputs = {Guess::constant(at(end))}};
}

TEST(SeveralStarts, ListsDistinctOptimaTheCheapestFirst) {
  const std::vector<SeveralSolutions::Start> starts{towards(1.2), towards(-1.2), towards(0.8),
                                                    towards(-0.7)};
  SeveralSolutions::Options options{.intervals_per_phase = 5};
  for (const int threads : {1, 3}) {
    options.threads = threads;
    const SeveralSolutions found = solve_from(valleys(), starts, options);
    ASSERT_EQ(found.optima.size(), 2u);
    EXPECT_EQ(found.optimum_of, (std::vector<int>{1, 0, 1, 0})) << threads << " threads";
    // Minima of the quartic, shifted by a small effort: x = -1.03 and x = 0.97.
    EXPECT_NEAR(found.optima[0].trajectory.final_state()[0], -1.03, 0.01);
    EXPECT_NEAR(found.optima[1].trajectory.final_state()[0], 0.97, 0.01);
    EXPECT_LT(found.optima[0].cost, found.optima[1].cost - 0.4);
    EXPECT_TRUE(found.failed.empty());
  }
}

// Paths around a disc that lies off the straight line: a shorter path and a longer one. Scenes have
// a size of 1 m or 0.3 mm, or the same size in other units.
OptimalControlProblem around_a_disc(double size) {
  Phase<2, 2> go{
      "go", [](const auto&, const auto&, const auto& u) { return std::decay_t<decltype(u)>{u}; },
      exactly(1.0)};
  go.keep(
        "disc",
        [size](const auto&, const auto& x) {
          const auto a = x[0] - 0.5 * size, b = x[1] - 0.1 * size;
          return a * a + b * b;
        },
        at_least(0.09 * size * size))
      .allow("disc", 1e-2 * size * size)  // the grid is coarse
      .reach("there", [](const auto&, const auto& x) { return x; }, {exactly(size), exactly(0.0)})
      .minimise("effort", [](const auto&, const auto&, const auto& u) {
        return 0.5 * (u[0] * u[0] + u[1] * u[1]);
      });
  OptimalControlProblem ocp("around a disc");
  ocp.start_at({0.0, 0.0}).then(go);
  return ocp;
}

TEST(SeveralStarts, AreDistinguishedAtAnyScale) {
  std::vector<double> best;
  for (const double size : {1.0, 3e-4}) {
    const auto by_way_of = [size](double y) {
      return SeveralSolutions::Start{
          .states = {
              Guess::interpolate(Vec<double, 2>(0.0, y * size), Vec<double, 2>(size, y * size))}};
    };
    const SeveralSolutions found =
        solve_from(around_a_disc(size), {by_way_of(1.0), by_way_of(-1.0), by_way_of(-0.8)});
    ASSERT_TRUE(found.failed.empty()) << found.failed.front().message;
    EXPECT_EQ(found.optimum_of, (std::vector<int>{1, 0, 0})) << size;
    ASSERT_EQ(found.optima.size(), 2u) << size;
    EXPECT_LT(found.optima[0].cost, 0.9 * found.optima[1].cost);
    best.push_back(found.optima[0].cost / (size * size));
  }
  EXPECT_NEAR(best[1], best[0], 1e-4 * best[0]);  // the tolerance of the solver for small numbers
}

// With a coarse distance measure all optima count as one. The cheapest represents them, independent
// of the start that found it.
TEST(SeveralStarts, KeepsTheCheapestOfEqualOptima) {
  const SeveralSolutions found =
      solve_from(valleys(), {towards(1.2), towards(-1.2)},
                 {.intervals_per_phase = 5, .same_point = 10.0, .same_cost = 10.0});
  ASSERT_EQ(found.optima.size(), 1u);
  EXPECT_EQ(found.optimum_of, (std::vector<int>{0, 0}));
  EXPECT_NEAR(found.optima[0].trajectory.final_state()[0], -1.03, 0.01);
}

TEST(SeveralStarts, AreBitIdenticalForAnyNumberOfThreads) {
  const std::vector<SeveralSolutions::Start> starts{towards(1.2), towards(-1.2), towards(0.8),
                                                    towards(-0.7)};
  const auto found_by = [&](int threads) {
    return solve_from(valleys(), starts, {.intervals_per_phase = 5, .threads = threads});
  };
  const SeveralSolutions one = found_by(1);
  for (const int threads : {2, 3, 8}) {
    const SeveralSolutions several = found_by(threads);
    EXPECT_EQ(one.optimum_of, several.optimum_of) << threads << " threads";
    ASSERT_EQ(one.optima.size(), several.optima.size());
    for (std::size_t i = 0; i < one.optima.size(); ++i) {
      EXPECT_EQ(one.optima[i].iterations, several.optima[i].iterations);
      EXPECT_EQ(one.optima[i].cost, several.optima[i].cost);
      EXPECT_EQ(one.optima[i].point.w, several.optima[i].point.w);
      EXPECT_EQ(one.optima[i].point.lambda, several.optima[i].point.lambda);
      EXPECT_EQ(one.optima[i].point.z, several.optima[i].point.z);
    }
  }
}

TEST(SeveralStarts, ReturnsFailedStarts) {
  SeveralSolutions::Options options{.intervals_per_phase = 5};
  options.make_solver = [] { return make_native_solver({.max_iterations = 1}); };
  const SeveralSolutions none = solve_from(valleys(), {towards(1.2), towards(-1.2)}, options);
  EXPECT_FALSE(none.ok());
  EXPECT_EQ(none.optimum_of, (std::vector<int>{-1, -1}));
  EXPECT_EQ(none.failed.size(), 2u);
}

TEST(SeveralStarts, RejectsInvalidStartsBeforeSolving) {
  const auto message = [](const SeveralSolutions::Start& start) {
    return error_of<DefinitionError>([&] { solve_from(valleys(), {towards(1.0), start}); });
  };
  EXPECT_NE(message({.durations = {1.0, 2.0}}).find("start 1: 2 durations"), std::string::npos);
  EXPECT_NE(message({.states = {Guess::constant(VectorXd::Zero(2))}}).find("phase 'roll'"),
            std::string::npos);
  EXPECT_THROW(solve_from(valleys(), {}), DefinitionError);
}

// A hanging pendulum must be upright after 3 s with a torque that cannot lift it, T = 0.6 m g l.
// The homotopy goes from zero to full gravity.
struct Pendulum {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u, const Vec<S, 1>& p) const {
    return {x[1], u[0] - p[0] * sin(x[0])};
  }
};

TEST(Homotopy, ContinuesASolutionToTheTargetProblem) {
  Phase<2, 1, 1> swing{"swing", Pendulum{}, exactly(3.0)};
  swing.data("gravity", Vec<double, 1>{0.0})
      .bound_input(0, between(-6.0, 6.0))
      .reach("stands", [](const auto&, const auto& x) { return x; }, {exactly(M_PI), exactly(0.0)})
      .minimise("effort", [](const auto&, const auto&, const auto& u) { return u[0] * u[0]; });
  OptimalControlProblem ocp("swing up");
  ocp.start_at({0.0, 0.0}).then(swing);
  MultipleShooting shooting(ocp,
                            {.intervals_per_phase = 30, .integrator = runge_kutta4({.steps = 2})});
  const auto solver = make_native_solver();
  const VectorXd none = VectorXd::Zero(1), earth = VectorXd::Constant(1, 9.81);
  const Homotopy way = solve_along(shooting, *solver, "gravity", none, earth);
  ASSERT_TRUE(way.ok()) << way.reached << " " << way.solution.message;
  EXPECT_EQ(way.steps.front().at, 0.0);
  // Without gravity: u = a - b t from rest to rest, 12 pi^2 / T^3.
  EXPECT_NEAR(way.steps.front().cost, 12.0 * M_PI * M_PI / 27.0, 2e-3 * way.steps.front().cost);
  EXPECT_NEAR(way.solution.trajectory.final_state()[0], M_PI, 1e-6);
  EXPECT_EQ(shooting.data().parameters[0][0], 9.81);

  EXPECT_THROW(solve_along(shooting, *solver, "levity", none, earth), DefinitionError);
  EXPECT_THROW(solve_along(shooting, *solver, "gravity", VectorXd::Zero(2), earth),
               DefinitionError);
}

// 1.02 m in 1 s with at most 1 m/s. After half of the homotopy, the next step is limited to the
// end, where the solve fails. The step after that is half as long and does not repeat the same one.
TEST(Homotopy, DoesNotRepeatATry) {
  Phase<1, 1, 1> go{"go",
                    [](const auto&, const auto&, const auto& u, const auto&) {
                      return std::decay_t<decltype(u)>{u};
                    },
                    exactly(1.0)};
  go.data("goal", VectorXd::Zero(1))
      .bound_input(0, between(-1.0, 1.0))
      .reach(
          "there",
          [](const auto&, const auto& x, const auto&, const auto& p) { return x[0] - p[0]; },
          exactly(0.0))
      .minimise("effort",
                [](const auto&, const auto&, const auto& u, const auto&) { return u[0] * u[0]; });
  OptimalControlProblem ocp("too far");
  ocp.start_at({0.0}).then(go);
  MultipleShooting shooting(ocp, {.intervals_per_phase = 10, .integrator = runge_kutta4()});
  const auto solver = make_native_solver();
  const Homotopy way =
      solve_along(shooting, *solver, "goal", VectorXd::Zero(1), VectorXd::Constant(1, 1.02));
  EXPECT_FALSE(way.ok());
  EXPECT_NEAR(way.reached, 1.0 / 1.02, 2e-3);  // one to two times least_step
  for (std::size_t i = 1; i < way.steps.size(); ++i)
    EXPECT_NE(way.steps[i].at, way.steps[i - 1].at) << "step " << i;
}

}  // namespace
}  // namespace saltus
