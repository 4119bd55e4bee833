// The search over sequences of nonlinear problems: its results and its certificates.
#include "saltus/sequences/search.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "problems/library/mode_graphs.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {
namespace {

// Lower bound of all sequences: the relaxed optimum with intermediate efforts
// (a08_fishing_relaxed.cpp).
constexpr double relaxed_fishing = 1.344081198;

TEST(Search, UsesAllAllowedFishingTrips) {
  double last = infinity;
  for (const int at_most : {2, 5, 9}) {
    const SequenceResult found =
        search(library::fishing_modes(),
               {.at_most = at_most, .intervals_per_phase = 6, .integrator = runge_kutta8()});
    ASSERT_TRUE(found.found()) << at_most << ": " << found.message;
    EXPECT_EQ(found.guarantee, SequenceResult::Guarantee::enumerated);
    EXPECT_EQ(found.lower_bound, -infinity);
    EXPECT_LE(static_cast<int>(found.sequence.size()), at_most);
    EXPECT_GT(found.cost, relaxed_fishing);
    EXPECT_LE(found.cost, last);
    EXPECT_NEAR(found.solution.cost, found.cost, 1e-12);
    last = found.cost;
  }
  EXPECT_NEAR(last, 1.3452952183, 1e-6);  // a06_fishing.cpp, with coarser intervals
  EXPECT_NE(search(library::fishing_modes(), {.at_most = 2}).message.find("number of phases"),
            std::string::npos)
      << "it says why there is no bound";
}

// x' = u - x^3 pushed up or down. The search prunes prefixes with fixed times that cost more, and
// keeps the optimum.
struct Pushed {
  double push;
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x, const Vec<S, 1>& u) const {
    return Vec<S, 1>(push + u[0] - x[0] * x[0] * x[0]);
  }
};

ModeGraph pushes() {
  ModeGraph graph("pushes");
  for (const double push : {0.0, 1.0, -1.0}) {
    const char* name = push == 0.0 ? "rest" : push > 0.0 ? "up" : "down";
    Phase<1, 1> phase{name, Pushed{push}, exactly(0.3)};
    phase.bound_input(0, between(-0.2, 0.2))
        .minimise("off", [push](const auto&, const auto& x, const auto& u) {
          return x[0] * x[0] + 0.1 * u[0] * u[0] + 0.02 * push * push;
        });
    graph.mode(phase);
  }
  graph.all_transitions().start_at({0.8}).minimise_at_end<1>(
      "end", [](const auto&, const auto& x) { return x[0] * x[0]; });
  return graph;
}

TEST(Search, ExcludesPrefixesAboveTheBestCost) {
  const SearchOptions every{.phases = 4, .intervals_per_phase = 3};
  SearchOptions pruned = every;
  pruned.costs_are_nonnegative = true;
  const SequenceResult a = search(pushes(), every), b = search(pushes(), pruned);
  EXPECT_EQ(a.guarantee, SequenceResult::Guarantee::enumerated) << a.message;
  EXPECT_EQ(b.guarantee, SequenceResult::Guarantee::enumerated) << b.message;
  EXPECT_EQ(a.sequence, b.sequence);
  EXPECT_NEAR(a.cost, b.cost, 1e-8);
  EXPECT_GE(a.nodes, 81);  // 3^4, each from one or more starts
  EXPECT_LT(b.nodes, a.nodes);
}

// A ball dropped from 1 m loses a fifth of its speed in every bounce. It bounces sqrt(2 h / g) =
// 0.4515 s after its release, at 1.1740 s and at 1.7520 s. For 1.5 s, two bounces are correct.
struct Falling {
  template <class S>
  Vec<S, 2> operator()(const S&, const Vec<S, 2>& x, const Vec<S, 1>& u) const {
    return {x[1], u[0] - 9.81};
  }
};

TEST(Search, FindsTheNumberOfEventsOfGuardsAndJumps) {
  const auto height = [](const auto&, const auto& x) { return x[0]; };
  const Jump bounce = jump<2>("bounce", [](const auto&, const auto& x) {
    return std::decay_t<decltype(x)>{x[0], -0.8 * x[1]};
  });
  Phase<2, 1> fly{"fly", Falling{}, between(0.05, 1.5)};
  fly.guess_state(Guess::simulate())
      .guess_duration(0.5)
      .bound_input(0, between(-1e-3, 1e-3))
      .keep("above ground", height, at_least(-1e-6))
      .minimise("blow", [](const auto&, const auto&, const auto& u) { return u[0] * u[0]; });
  ModeGraph graph("ball");
  graph.mode(fly)
      .transition_when<2>("fly", "fly", "contact", height, Crossing::falling, bounce)
      .start_at({1.0, 0.0})
      .total_time(exactly(1.5));
  const SequenceResult found = search(graph, {.at_most = 5, .intervals_per_phase = 8});
  ASSERT_EQ(found.sequence.size(), 3u) << found.message;
  const double first = std::sqrt(2.0 / 9.81);
  EXPECT_NEAR(found.solution.durations[0], first, 2e-4);  // the input changes it by about as much
  EXPECT_NEAR(found.solution.durations[1], 1.6 * first, 5e-4);
  EXPECT_EQ(found.solution.crossings.size(), 2u);
}

// A motor may run for one second in total, in any two of four half seconds.
TEST(Search, LimitsAnIntegralAlongTheWholeSequence) {
  const auto motor = [](double drive) {
    return [drive](const auto&, const auto& x, const auto& u) { return drive + u[0] - 0.1 * x[0]; };
  };
  Phase<1, 1> off{"off", motor(0.0), exactly(0.5)}, on{"on", motor(1.0), exactly(0.5)};
  on.bound_integral(
      "run", [](const auto& t, const auto&) { return 0.0 * t + 1.0; }, at_most(1.0 + 1e-9));
  ModeGraph graph("motor");
  for (auto* phase : {&off, &on}) {
    phase->bound_input(0, exactly(0.0)).minimise("off the mark", [](const auto&, const auto& x) {
      return (x[0] - 1.0) * (x[0] - 1.0);
    });
    graph.mode(*phase);
  }
  graph.all_transitions().start_at({0.0});
  const SequenceResult found = search(graph, {.phases = 4, .intervals_per_phase = 3});
  ASSERT_TRUE(found.found()) << found.message;
  EXPECT_EQ(found.guarantee, SequenceResult::Guarantee::enumerated);
  EXPECT_EQ(std::count(found.sequence.begin(), found.sequence.end(), "on"), 2) << found.message;
  EXPECT_NE(found.message.find("mode 'on' limits an integral"), std::string::npos) << found.message;
  EXPECT_NEAR(found.solution.integrals.back().value, 1.0, 1e-8);
}

// Three ticks of 0.1 s leave 0.2 s for the rest except for rounding, and the rest lasts 0.2 s at
// least.
TEST(Search, AcceptsTimesWithinRounding) {
  const auto drift = [](double speed) {
    return [speed](const auto&, const auto& x) { return speed + 0.0 * x[0]; };
  };
  Phase<1, 0> tick{"tick", drift(1.0), exactly(0.1)}, rest{"rest", drift(-1.0), between(0.2, 1.0)};
  rest.guess_duration(0.3);
  ModeGraph graph("ticks");
  for (auto* phase : {&tick, &rest}) {
    phase->minimise("off", [](const auto&, const auto& x) { return x[0] * x[0]; });
    graph.mode(*phase);
  }
  graph.transition("tick", "tick")
      .transition("tick", "rest")
      .begin_in({"tick"})
      .end_in({"rest"})
      .start_at({-0.3})
      .total_time(exactly(0.5))
      .costs(CostRule::integrated);
  const SequenceResult found = search(graph, {.at_most = 4, .intervals_per_phase = 3});
  ASSERT_EQ(found.guarantee, SequenceResult::Guarantee::enumerated) << found.message;
  EXPECT_EQ(found.sequence.size(), 4u) << found.message;
  EXPECT_NEAR(found.cost, (0.3 * 0.3 * 0.3 + 0.2 * 0.2 * 0.2) / 3.0, 1e-9);
}

TEST(Search, StoppedSearchHasNoCertificate) {
  const SequenceResult found = search(
      pushes(),
      {.phases = 4, .max_nodes = 6, .intervals_per_phase = 3, .costs_are_nonnegative = true});
  EXPECT_EQ(found.guarantee, SequenceResult::Guarantee::incomplete) << found.message;
}

}  // namespace
}  // namespace saltus
