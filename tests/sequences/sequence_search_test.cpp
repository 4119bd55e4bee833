// Branch and bound over sequences against enumeration and a mixed-integer solver, over several
// ticks, and with early stops.
#include "saltus/sequences/sequence_search.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "problems/library/mode_graphs.hpp"
#include "saltus/core/error.hpp"
#include "saltus/core/random.hpp"
#include "saltus/integrators/zero_order_hold.hpp"
#include "saltus/sequences/search.hpp"
#include "saltus/solver/native_solver.hpp"
#include "saltus/transcription/multiple_shooting.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

using library::cart_between_walls;
using library::thermostats;
using library::two_tanks;

// Quadratic programs are solved to 1e-8, and their duality gap is relative to the cost.
constexpr double same_cost = 1e-6;

// The cheapest of all sequences, each solved as a separate OptimalControlProblem.
double by_enumeration(const ModeGraph& graph, int phases) {
  double best = infinity;
  const auto solver = make_native_solver();
  std::vector<int> path;
  const auto extend = [&](auto&& self) -> void {
    if (static_cast<int>(path.size()) == phases) {
      MultipleShooting shooting(graph.problem(path),
                                {.intervals_per_phase = 1, .integrator = zero_order_hold()});
      const Solution s = solve(shooting, *solver);
      // The sequence of samples. The search also reports plans that violate bounds between samples.
      if (s.ok() || s.status == SolveStatus::coarse_grid) best = std::min(best, s.cost);
      return;
    }
    for (int mode = 0; mode < graph.size(); ++mode) {
      if (!graph.may_append(path, mode, {})) continue;
      path.push_back(mode);
      self(self);
      path.pop_back();
    }
  };
  extend(extend);
  return best;
}

void expect_as_enumerated(const ModeGraph& graph, int phases) {
  const double best = by_enumeration(graph, phases);
  const SequenceResult found = search(graph, {.phases = phases});
  if (best == infinity) {
    EXPECT_EQ(found.guarantee, SequenceResult::Guarantee::infeasible) << found.message;
    return;
  }
  EXPECT_EQ(found.guarantee, SequenceResult::Guarantee::optimal) << found.message;
  EXPECT_NEAR(found.cost, best, same_cost * best);
  EXPECT_LE(found.lower_bound, best * (1.0 + same_cost));
  EXPECT_LE(found.gap(), 1.1e-6);
  ASSERT_TRUE(found.solution.ok() || found.solution.status == SolveStatus::coarse_grid)
      << found.solution.message;
  EXPECT_NEAR(found.solution.cost, found.cost, same_cost * best);
}

TEST(SequenceSearch, FindsTheCheapestOfAllSequences) {
  // In contact at the start; free; in contact with the left wall from the second phase on.
  for (const VectorXd& start : {VectorXd(Vec<double, 4>(0.45, -0.1, 0.0, 0.2)),
                                VectorXd(Vec<double, 4>(0.2, 0.02, -0.3, 0.1)),
                                VectorXd(Vec<double, 4>(-0.45, 0.03, -0.4, 0.3))})
    expect_as_enumerated(cart_between_walls(start), 3);
  expect_as_enumerated(two_tanks(Vec<double, 2>(0.1, 0.3)), 4);
  expect_as_enumerated(thermostats(Vec<double, 3>(18.0, 20.0, 19.0)), 4);
}

// Optima from benchmarks/compare_mode_search.py: SCIP 10.0 through pyscipopt with gap 0 and
// feasibility 1e-9, from an independent implementation of the equations.
struct Certified {
  ModeGraph (*graph)(const VectorXd& start);
  int phases;
  std::vector<double> start;
  double optimum;
};
std::vector<Certified> certified() {
  return {
      {cart_between_walls,
       5,
       {0.088228190899524439, -0.028769445797548393, -0.48145533355287318, -0.12848282985013804},
       1.96343578},
      {cart_between_walls,
       5,
       {-0.39807282871287009, 0.090663803485813294, 0.27272782272939355, 0.43326113359521923},
       infinity},
      {cart_between_walls,
       5,
       {-0.12733219395795575, 0.060038684662459207, 0.35616812291694644, -0.42594351882842063},
       2.08682753},
      {cart_between_walls,
       5,
       {0.16333302454804088, 0.034144866465171536, -0.37556944968911699, -0.46521960193999379},
       10.0313038},
      {cart_between_walls,
       10,
       {-0.05883861482199465, 0.071540436431242554, -0.12740349257331585, -0.15145084249342733},
       0.450715415},
      {cart_between_walls,
       15,
       {0.26994603322892019, 0.059782444215597141, -0.49538142885663594, -0.14935939867139747},
       0.52909308},
      {cart_between_walls,
       15,
       {-0.12733219395795575, 0.060038684662459207, 0.35616812291694644, -0.42594351882842063},
       0.511480898},
      {thermostats, 6, {20.856568812434229, 19.722560160378279, 17.601995665459196}, 6.21144095},
      {thermostats, 6, {19.543344435824242, 19.112206697345194, 20.520693297642961}, 5.10906663},
      {thermostats, 6, {22.829975911720844, 18.149702386809913, 20.38478024645773}, 3.45784648},
  };
}

TEST(SequenceSearch, FindsTheOptimaOfAMixedIntegerSolver) {
  for (const Certified& known : certified()) {
    const VectorXd x = Eigen::Map<const VectorXd>(known.start.data(), std::ssize(known.start));
    SequenceSearch search(known.graph(x), {.phases = known.phases, .confirm = false});
    const SequenceResult found = search.solve(x);
    if (known.optimum == infinity) {
      EXPECT_EQ(found.guarantee, SequenceResult::Guarantee::infeasible);
      continue;
    }
    EXPECT_EQ(found.guarantee, SequenceResult::Guarantee::optimal) << found.message;
    EXPECT_NEAR(found.cost, known.optimum, same_cost * known.optimum);
  }
}

// 200 nodes take at most the time of 250 of their programs.
TEST(SequenceSearch, HasLittleOverhead) {
#ifndef NDEBUG
  GTEST_SKIP() << "measured in optimised builds only";
#endif
  constexpr int tries = 8;  // the minimum has the least disturbance
  const auto cost = [](ModeGraph (*graph)(const VectorXd&), const VectorXd& x) {
    SequenceSearch search(graph(x), {.phases = 15, .gap = 0.0, .max_nodes = 200, .confirm = false});
    double least = infinity;
    for (int i = 0; i < tries; ++i) {
      const SequenceResult found = search.solve(x);
      least = std::min(least, found.cpu_seconds / found.solver_seconds);
    }
    return least;
  };
  EXPECT_LE(cost(cart_between_walls, Vec<double, 4>(-0.127, 0.060, 0.356, -0.426)), 1.25);
  EXPECT_LE(cost(thermostats, Vec<double, 3>(20.9, 19.7, 17.6)), 1.25);
  EXPECT_LE(cost(two_tanks, Vec<double, 2>(0.1, 0.3)), 1.25);
}

// Warm and cold starts search the same tree. The warm start takes fewer iterations.
TEST(SequenceSearch, WarmNodesNeedFewerIterations) {
  const VectorXd x = Vec<double, 2>(0.1, 0.3);
  SequenceSearch warm(two_tanks(x), {.phases = 8, .confirm = false});
  SequenceSearch cold(two_tanks(x), {.phases = 8, .warm = false, .confirm = false});
  const SequenceResult a = warm.solve(x), b = cold.solve(x);
  EXPECT_NEAR(a.cost, b.cost, same_cost * b.cost);
  EXPECT_LT(a.iterations, b.iterations);
}

TEST(SequenceSearch, StoppedSearchHasABoundAndTheBestSoFar) {
  const VectorXd x = Vec<double, 2>(0.1, 0.3);
  const SequenceResult all = search(two_tanks(x), {.phases = 8});
  ASSERT_EQ(all.guarantee, SequenceResult::Guarantee::optimal);
  SequenceSearch stopped(two_tanks(x), {.phases = 8, .max_nodes = 12});
  const SequenceResult some = stopped.solve(x);
  EXPECT_EQ(some.guarantee, SequenceResult::Guarantee::bounded);
  EXPECT_LE(some.nodes, 13);
  ASSERT_TRUE(some.found());
  EXPECT_GE(some.cost, all.cost * (1.0 - same_cost));
  EXPECT_LE(some.lower_bound, all.cost * (1.0 + same_cost));
  EXPECT_GT(some.lower_bound, 0.0);
  EXPECT_GT(some.gap(), 1e-6);

  stopped.set_deadline(1e-9);
  const SequenceResult none = stopped.solve(x);
  EXPECT_EQ(none.guarantee, SequenceResult::Guarantee::bounded);
  EXPECT_FALSE(none.found());
  EXPECT_EQ(none.gap(), infinity);
}

// Compares every tick of a disturbed loop with and without the tree of the previous tick. `fewer`
// is the ratio of the numbers of nodes in all ticks.
void expect_loop(ModeGraph (*graph)(const VectorXd&), VectorXd x, int phases, int ticks,
                 double disturbance, double fewer) {
  Random random(7);
  SequenceSearch loop(graph(x), {.phases = phases, .confirm = false});
  SequenceSearch fresh(graph(x), {.phases = phases, .confirm = false});
  long nodes = 0, from_nothing = 0;
  for (int tick = 0; tick < ticks; ++tick) {
    const SequenceResult next = tick == 0 ? loop.solve(x) : loop.solve_next(x);
    const SequenceResult alone = fresh.solve(x, loop.before());
    ASSERT_EQ(next.guarantee, SequenceResult::Guarantee::optimal) << "tick " << tick;
    EXPECT_NEAR(next.cost, alone.cost, 2.0 * same_cost * alone.cost) << "tick " << tick;
    if (tick > 0) {
      EXPECT_GT(next.reused, 0);
      nodes += next.nodes;
      from_nothing += alone.nodes;
    }
    x = next.states[1];
    for (double& value : x) value += disturbance * random.uniform(-1.0, 1.0);
  }
  EXPECT_LT(static_cast<double>(nodes), fewer * static_cast<double>(from_nothing));
}

TEST(SequenceSearch, ReusesTheTreeOfTheLastTick) {
  // Most nodes prove again that the same sequences are infeasible.
  expect_loop(cart_between_walls, Vec<double, 4>(0.3, 0.02, -0.3, 0.0), 6, 10, 1e-3, 0.5);
  expect_loop(two_tanks, Vec<double, 2>(0.1, 0.3), 6, 10, 1e-3, 1.0);
  // The disturbance is half the effect of heating in a sample, so that sequences change.
  expect_loop(thermostats, Vec<double, 3>(18.0, 20.0, 19.0), 6, 25, 0.7, 1.2);
  expect_loop(thermostats, Vec<double, 3>(18.0, 20.0, 19.0), 6, 8, 0.02, 1.0);
}

// Bounds and proofs of the last tick remain valid after any change of the state. The search finds
// the best sequence even if it was expensive or infeasible before.
void expect_throws(ModeGraph (*graph)(const VectorXd&), const VectorXd& low, const VectorXd& high,
                   int phases, int ticks) {
  Random random(11);
  SequenceSearch loop(graph(low), {.phases = phases, .confirm = false});
  SequenceSearch fresh(graph(low), {.phases = phases, .confirm = false});
  int moved = 0;
  VectorXd x = 0.5 * (low + high);
  for (int tick = 0; tick < ticks; ++tick) {
    const SequenceResult next = tick == 0 ? loop.solve(x) : loop.solve_next(x);
    const SequenceResult alone = fresh.solve(x, loop.before());
    ASSERT_EQ(next.guarantee, alone.guarantee) << "tick " << tick;
    if (alone.found()) {
      EXPECT_NEAR(next.cost, alone.cost, 2.0 * same_cost * alone.cost) << "tick " << tick;
      EXPECT_LE(next.lower_bound, alone.cost * (1.0 + same_cost)) << "tick " << tick;
    }
    moved += next.reused > 0 && alone.found() ? 1 : 0;
    for (int i = 0; i < x.size(); ++i) x[i] = random.uniform(low[i], high[i]);
  }
  EXPECT_GE(moved, ticks / 4) << "or nothing was shown";
}

TEST(SequenceSearch, BoundsOfTheLastTickHoldForAnyState) {
  const VectorXd far = Vec<double, 4>(0.45, 0.12, 0.4, 0.4);
  expect_throws(cart_between_walls, -far, far, 5, 40);
  expect_throws(two_tanks, Vec<double, 2>(0.06, 0.06), Vec<double, 2>(0.55, 0.55), 5, 20);
  expect_throws(thermostats, Vec<double, 3>(17.2, 17.2, 17.2), Vec<double, 3>(24.0, 24.0, 24.0), 5,
                20);
}

// Every second tick is stopped early. Unvisited leaves contain shifted data of the previous tick,
// whose last phase is invented. Of 700 seeds, an earlier version used such data as a bound with
// two, which are among these seeds. The other two seeds are arbitrary.
TEST(SequenceSearch, BoundsHoldAfterStoppedTicks) {
  for (const int seed : {229, 230, 423, 424}) {
    Random random(seed);
    VectorXd x = Vec<double, 2>(random.uniform(0.1, 0.5), random.uniform(0.15, 0.55));
    SequenceSearch loop(two_tanks(x), {.phases = 6, .confirm = false});
    SequenceSearch fresh(two_tanks(x), {.phases = 6, .confirm = false});
    SequenceResult next = loop.solve(x);
    for (int tick = 0; tick < 6 && next.found(); ++tick) {
      x = next.states[1];
      for (double& value : x) value += random.uniform(-0.06, 0.06);
      const bool all = tick % 2 == 1;
      loop.set_max_nodes(all ? 1000000 : random.integer(7, 12));
      next = loop.solve_next(x);
      const SequenceResult alone = fresh.solve(x, loop.before());
      const double most = alone.cost * (1.0 + same_cost);
      EXPECT_LE(next.lower_bound, most) << "seed " << seed << ", tick " << tick;
      if (all) {
        EXPECT_LE(next.cost, most) << "seed " << seed << ", tick " << tick;
      }
    }
  }
}

// The applied mode and its elapsed duration are kept after a tick without a result.
TEST(SequenceSearch, RemembersTheAppliedInputAfterATickWithoutResult) {
  const VectorXd x = Vec<double, 3>(20.0, 20.0, 20.0), hopeless = Vec<double, 3>(10.0, 10.0, 10.0);
  SequenceSearch loop(thermostats(x), {.phases = 5, .confirm = false});
  ASSERT_TRUE(loop.solve(x, {.mode = 0, .phases = 1}).found());
  ASSERT_FALSE(loop.solve_next(hopeless).found());
  const ModeGraph::History before = loop.before();
  ASSERT_GE(before.mode, 0);
  loop.solve_next(x);
  EXPECT_EQ(loop.before().mode, before.mode);
  EXPECT_EQ(loop.before().phases, before.phases);
}

TEST(SequenceSearch, RejectsAnInvalidState) {
  const VectorXd x = Vec<double, 3>(20.0, 20.0, 20.0);
  SequenceSearch loop(thermostats(x), {.phases = 3, .confirm = false});
  const auto message = [&](const VectorXd& state) -> std::string {
    const std::string first = error_of<DefinitionError>([&] { loop.solve(state); }, "");
    return first + error_of<DefinitionError>([&] { loop.solve_next(state); }, "");
  };
  ASSERT_TRUE(loop.solve(x).found());
  const std::string size = "the state has 2 entries, expected 3", nan = "the state is not finite";
  for (const auto& [state, words] :
       {std::pair{VectorXd(x.head(2)), size}, {VectorXd(x * std::nan("")), nan}}) {
    const std::string text = message(state);
    EXPECT_NE(text.find(words), std::string::npos) << text;
    EXPECT_NE(text.find(words), text.rfind(words)) << "twice, by both, in: " << text;
  }
  EXPECT_GT(loop.solve_next(x).reused, 0) << "a rejected call changes nothing";
}

// x' = -x + u or x' = x - u, |u| <= 1. A non-convex problem is rejected with its name.
TEST(SequenceSearch, ReportsWhyAProblemIsNotConvexInSampledTime) {
  const auto reason = [](auto dynamics, Bounds duration,
                         Bounds total = unbounded()) -> std::string {
    Phase<1, 1> phase{"only", dynamics, duration};
    phase.guess_duration(0.5).minimise(
        "effort", [](const auto&, const auto&, const auto& u) { return u[0] * u[0]; });
    ModeGraph graph;
    graph.mode(phase).all_transitions().start_at({1.0}).total_time(total);
    return error_of<DefinitionError>([&] { SequenceSearch(graph, {.phases = 3}); }, "");
  };
  const auto linear = [](const auto&, const auto& x, const auto& u) {
    return std::decay_t<decltype(x)>(u - x);
  };
  const auto cubic = [](const auto&, const auto& x, const auto& u) {
    return std::decay_t<decltype(x)>(u[0] - x[0] * x[0] * x[0]);
  };
  EXPECT_EQ(reason(linear, exactly(0.1)), "");
  EXPECT_EQ(reason(linear, exactly(0.1), exactly(0.3)), "");  // except for rounding
  EXPECT_NE(reason(linear, exactly(0.1), exactly(0.2))
                .find("3 phases of 0.1 s last 0.3 s, but the total time is [0.2, 0.2] s"),
            std::string::npos)
      << reason(linear, exactly(0.1), exactly(0.2));
  EXPECT_NE(reason(linear, exactly(0.1), at_least(0.4)), "");
  EXPECT_NE(reason(linear, between(0.1, 1.0)).find("'only' has a free duration"),
            std::string::npos);
  EXPECT_NE(reason(cubic, exactly(0.1)).find("'only' is not affine"), std::string::npos);
}

}  // namespace
}  // namespace saltus
