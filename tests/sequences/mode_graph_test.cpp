// Graphs of modes: paths as problems, and one sentence with names for each mistake, before a solve.
#include "saltus/sequences/mode_graph.hpp"

#include <gtest/gtest.h>

#include <string>

#include "saltus/core/error.hpp"
#include "saltus/sequences/search.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

struct Drift {
  double speed;
  template <class S>
  Vec<S, 1> operator()(const S&, const Vec<S, 1>& x) const {
    return Vec<S, 1>(speed + 0.0 * x[0]);
  }
};

Phase<1, 0> mode(const char* name, double speed, Bounds duration = exactly(1.0)) {
  Phase<1, 0> phase{name, Drift{speed}, duration};
  phase.guess_duration(1.0).minimise("distance",
                                     [](const auto&, const auto& x) { return x[0] * x[0]; });
  return phase;
}

ModeGraph up_and_down(Bounds duration = exactly(1.0)) {
  ModeGraph graph("drift");
  graph.mode(mode("up", 1.0, duration)).mode(mode("down", -1.0, duration)).start_at({0.5});
  return graph;
}

std::string message_of(const ModeGraph& graph, bool limited = true) {
  return error_of<DefinitionError>([&] { graph.check(limited); }, "");
}

void expect_words(const std::string& message, const std::vector<std::string>& words) {
  for (const std::string& word : words)
    EXPECT_NE(message.find(word), std::string::npos) << "'" << word << "' in: " << message;
}

TEST(ModeGraph, PathIsAnOptimalControlProblem) {
  const Jump twice = jump<1>(
      "twice", [](const auto&, const auto& x) -> std::decay_t<decltype(x)> { return 2 * x; });
  ModeGraph graph = up_and_down();
  graph.transition("up", "down", twice)
      .transition("down", "up")
      .minimise_at_end<1>("end", [](const auto&, const auto& x) { return x[0]; });
  ASSERT_EQ(message_of(graph), "");
  const OptimalControlProblem problem = graph.problem(std::vector<int>{0, 1, 0});
  problem.check();
  ASSERT_EQ(problem.phases().size(), 3u);
  EXPECT_EQ(problem.phases()[1].name, "down 2");
  EXPECT_EQ(problem.jumps()[1].name, "twice");
  EXPECT_EQ(problem.jumps()[2].name, "identity");
  // Constraints at the end are in the last phase only.
  EXPECT_EQ(problem.phases()[0].terms.size(), 1u);
  EXPECT_EQ(problem.phases()[2].terms.size(), 2u);
}

TEST(ModeGraph, RunningCostsAreIntegralsByDefault) {
  ModeGraph graph = up_and_down();
  EXPECT_EQ(graph.problem(std::vector<int>{0}).cost_rule(), CostRule::integrated);
  graph.costs(CostRule::nodes);
  EXPECT_EQ(graph.problem(std::vector<int>{0}).cost_rule(), CostRule::nodes);
}

TEST(ModeGraph, DwellAndEntriesLimitAppending) {
  ModeGraph graph = up_and_down();
  graph.all_transitions().dwell("up", 2).enter_at_most("down", 1);
  ASSERT_EQ(message_of(graph), "");
  const auto may = [&](std::vector<int> path, int next, ModeGraph::History before = {}) {
    return graph.may_append(path, next, before);
  };
  EXPECT_FALSE(may({0}, 1));
  EXPECT_TRUE(may({0, 0}, 1));
  EXPECT_TRUE(may({0}, 1, {.mode = 0, .phases = 1}));   // the mode has lasted two phases
  EXPECT_FALSE(may({0}, 1, {.mode = 1, .phases = 1}));  // the mode has just been entered
  EXPECT_TRUE(may({1}, 1));                             // remaining in a mode is not an entry
  EXPECT_FALSE(may({1, 0, 0}, 1));                      // a second one
}

TEST(ModeGraph, RejectsAnUnreachableMode) {
  ModeGraph graph = up_and_down();
  graph.begin_in({"up"}).transition("up", "up").transition("down", "up");
  expect_words(message_of(graph), {"'down'", "cannot be reached", "'up'"});
}

TEST(ModeGraph, RejectsAModeWithoutAPathToTheEnd) {
  ModeGraph graph = up_and_down();
  graph.end_in({"up"}).transition("up", "down").transition("down", "down");
  expect_words(message_of(graph), {"'down'", "end"});
}

TEST(ModeGraph, RejectsACycleOfZeroTime) {
  ModeGraph graph = up_and_down(between(0.0, 2.0));
  graph.transition("up", "down").transition("down", "up").total_time(exactly(2.0));
  expect_words(message_of(graph, false), {"'up' -> 'down' -> 'up'", "Zeno"});
  EXPECT_THROW(search(graph, {}), DefinitionError);
  EXPECT_EQ(message_of(graph, true), "");  // the search is limited

  ModeGraph dwelling = up_and_down(between(0.1, 2.0));
  dwelling.transition("up", "down").transition("down", "up").total_time(exactly(2.0));
  EXPECT_EQ(message_of(dwelling, false), "");
  ModeGraph limited = up_and_down(between(0.0, 2.0));
  limited.transition("up", "down").transition("down", "up").enter_at_most("up", 2);
  EXPECT_EQ(message_of(limited, false), "");
}

// A field that changes sign at 10 s crosses the guard at that time, in every phase of a sequence.
TEST(ModeGraph, AcceptsALateGuard) {
  const auto turning = [](const auto& t, const auto& x) {
    return select(t - 10.0, 0.0 * x[0] - 1.0, 0.0 * x[0] + 1.0);
  };
  Phase<1, 0> tide{"tide", turning, between(0.5, 2.0)};
  tide.guess_duration(1.0);
  ModeGraph graph("tides");
  graph.mode(tide)
      .transition_when<1>(
          "tide", "tide", "low", [](const auto&, const auto& x) { return x[0]; }, Crossing::falling)
      .start_at({1.0});
  EXPECT_EQ(message_of(graph), "");
}

TEST(ModeGraph, RejectsContradictoryRules) {
  ModeGraph excluded = up_and_down();
  excluded.all_transitions().transition("up", "down").no_transition("up", "down");
  expect_words(message_of(excluded), {"'up'", "'down'", "declared and excluded"});

  ModeGraph twice = up_and_down();
  twice.transition("up", "down").transition("down", "up").transition("up", "down");
  expect_words(message_of(twice), {"'up'", "'down'", "twice"});

  ModeGraph stays = up_and_down();
  stays.transition("up", "down").transition("down", "up").dwell("up", 3);
  expect_words(message_of(stays), {"'up'", "3 phases", "no transition to itself"});

  ModeGraph useless = up_and_down();
  useless.transition("up", "down").transition("down", "up").no_transition("up", "up");
  expect_words(message_of(useless), {"'up'", "nothing allows it"});
}

TEST(ModeGraph, RejectsAnIndexOutOfRange) {
  const ModeGraph graph = up_and_down();
  for (const int i : {-1, 2, 1000000}) {
    const auto expect_refused = [&](const auto& access) {
      expect_error<DefinitionError>(access, {"modes 'drift'", "2 modes", std::to_string(i)});
    };
    const std::vector<int> path{0, i};
    expect_refused([&] { (void)graph.mode(i); });
    expect_refused([&] { (void)graph.may_follow(0, i); });
    expect_refused([&] { (void)graph.may_follow(i, 0); });
    expect_refused([&] { (void)graph.may_begin(i); });
    expect_refused([&] { (void)graph.may_end(i); });
    expect_refused([&] { (void)graph.has_event(i, 0); });
    expect_refused([&] { (void)graph.min_dwell(i); });
    expect_refused([&] { (void)graph.entries_of(i); });
    expect_refused([&] { (void)graph.names_of(path); });
    expect_refused([&] { (void)graph.problem(path); });
    expect_refused([&] { (void)graph.problem_of(i, true); });
    expect_refused([&] { (void)graph.end_problem(i, 0.0); });
    if (i < 0) continue;  // no mode before
    expect_refused([&] { (void)graph.may_append(path, 0, {}); });
    expect_refused([&] { (void)graph.may_append({}, 0, {.mode = i, .phases = 1}); });
  }
}

TEST(ModeGraph, RejectsMismatchedNamesAndSizes) {
  ModeGraph unknown = up_and_down();
  unknown.transition("up", "sideways");
  expect_words(message_of(unknown), {"'sideways'", "'up', 'down'"});

  ModeGraph start = up_and_down();
  start.all_transitions().start_at({0.5, 0.0});
  expect_words(message_of(start), {"2 states", "'up'", "has 1"});

  ModeGraph end = up_and_down();
  end.all_transitions().minimise_at_end<2>("end", [](const auto&, const auto& x) { return x[1]; });
  expect_words(message_of(end), {"'end'", "2 states", "'up'"});

  ModeGraph same;
  same.mode(mode("up", 1.0)).mode(mode("up", 2.0)).all_transitions().start_at({0.5});
  expect_words(message_of(same), {"two modes", "'up'"});

  const ModeGraph none;
  expect_words(message_of(none), {"there is no mode"});
  ModeGraph fine = up_and_down();
  fine.all_transitions();
  EXPECT_THROW(search(fine, {}), DefinitionError);                           // never ends
  EXPECT_THROW(search(fine, {.phases = 2, .at_most = 3}), DefinitionError);  // ambiguous
}

}  // namespace
}  // namespace saltus
