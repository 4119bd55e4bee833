// Schedules that change during use. A program edited in place equals a program built with the new
// schedule. Windows by mode equal windows from event to event. Neither allocates.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "saltus/core/error.hpp"
#include "tests/support/count_allocations.hpp"
#include "tests/support/errors.hpp"
#include "tests/support/event_problems.hpp"
#include "tests/support/walking_problem.hpp"

namespace saltus {
namespace {

using namespace testing_support;
using Times = std::vector<double>;

bool same(const VectorXd& a, const VectorXd& b) {
  return a.size() == b.size() && (a.array() == b.array()).all();
}

// Compares bounds and all evaluations at two random points. They are equal to the last bit.
void expect_same_program(NonlinearProgram& a, NonlinearProgram& b, std::mt19937& random) {
  ASSERT_EQ(a.variables(), b.variables());
  ASSERT_EQ(a.rows(), b.rows());
  ASSERT_TRUE(same(a.lower(), b.lower()));
  ASSERT_TRUE(same(a.upper(), b.upper()));
  ASSERT_TRUE(same(a.row_lower(), b.row_lower()));
  ASSERT_TRUE(same(a.row_upper(), b.row_upper()));
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const auto draw = [&](int n) {
    return VectorXd::NullaryExpr(n, [&](Eigen::Index) { return uniform(random); }).eval();
  };
  struct Values {
    VectorXd cost{1}, gradient, constraints, jacobian, hessian;
  };
  const auto evaluate = [](NonlinearProgram& nlp, const VectorXd& w, const VectorXd& lambda) {
    Values v;
    v.gradient.resize(nlp.variables());
    v.constraints.resize(nlp.rows());
    v.jacobian.resize(nlp.jacobian_pattern().entries());
    v.hessian.resize(nlp.hessian_pattern().entries());
    EXPECT_TRUE(nlp.objective(w.data(), v.cost[0]));
    EXPECT_TRUE(nlp.gradient(w.data(), v.gradient.data()));
    EXPECT_TRUE(nlp.constraints(w.data(), v.constraints.data()));
    EXPECT_TRUE(nlp.jacobian(w.data(), v.jacobian.data()));
    EXPECT_TRUE(nlp.hessian(w.data(), 1.0, lambda.data(), v.hessian.data(), Curvature::exact));
    return v;
  };
  for (int point = 0; point < 2; ++point) {
    const VectorXd w = draw(a.variables()), lambda = draw(a.rows());
    const Values one = evaluate(a, w, lambda), other = evaluate(b, w, lambda);
    ASSERT_TRUE(same(one.cost, other.cost));
    ASSERT_TRUE(same(one.gradient, other.gradient));
    ASSERT_TRUE(same(one.constraints, other.constraints));
    ASSERT_TRUE(same(one.jacobian, other.jacobian));
    ASSERT_TRUE(same(one.hessian, other.hessian));
  }
}

TEST(LiveSchedule, EditingInPlaceEqualsRebuilding) {
  constexpr unsigned seed = 7;
  std::mt19937 random(seed);
  MultipleShooting shooting = walking_problem(walking_schedule());
  Schedule schedule = walking_schedule();
  for (int trial = 0; trial < 400; ++trial) {
    const std::string edit = edit_at_random(schedule, 0.0, random);
    SCOPED_TRACE(::testing::Message() << "seed " << seed << ", edit " << trial << ": " << edit);
    shooting.set_schedule(schedule);
    MultipleShooting fresh = walking_problem(schedule);
    expect_same_program(shooting.nlp(), fresh.nlp(), random);
    if (HasFatalFailure()) return;
  }
}

// --- windows by mode
// ------------------------------------------------------------------------------

// The same terms, with windows by mode or from event to event.
MultipleShooting three_modes(const Schedule& schedule, bool by_mode) {
  const auto window = [&](const char* mode, std::optional<Instant> from,
                          std::optional<Instant> to) {
    return by_mode ? during(mode) : Window{.from = std::move(from), .to = std::move(to)};
  };
  const Window a = window("a", {}, event("1")), b = window("b", event("1"), event("2")),
               c = window("c", event("2"), {});
  Phase<1, 1> phase{"motion", Velocity{}, exactly(0.7)};
  phase.bound_input(0, exactly(0.5), a)
      .bound_input(0, at_most(2.0), b)
      .bound_state(0, between(-3.0, 3.0), b)
      .minimise("time", one, c)
      .track("effort", input, Vec<double, 1>{1.0}, b)
      .keep("a", state, at_most(1.0), a, soft("a", 2.0))
      .keep("b", state, at_most(2.0), b, soft("b", 3.0, Penalty::L2))
      .keep("c", state, at_most(3.0), c)
      .keep("push", input, at_most(4.0), c)
      .penalise_change(Vec<double, 1>{2.0});
  Phase<1, 1> next = phase;
  OptimalControlProblem ocp("modes");
  ocp.schedule(schedule).start_within({between(0.5, 1.5)}, Vec<double, 1>{1.0});
  ocp.then(phase).then(next);
  return {std::move(ocp), {.intervals_per_phase = 7, .integrator = runge_kutta4()}};
}

TEST(ModeWindow, EqualsTheWindowFromEventToEvent) {
  constexpr unsigned seed = 11;
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> anywhere(-0.3, 1.7);
  std::uniform_int_distribution<int> kind(0, 3);
  const auto schedule_at = [](double one, double two) {
    return Schedule({"a", "b", "c"}, {{"1", one}, {"2", two}});
  };
  MultipleShooting by_mode = three_modes(schedule_at(0.1, 0.2), true);
  MultipleShooting by_event = three_modes(schedule_at(0.1, 0.2), false);
  for (int trial = 0; trial < 500; ++trial) {
    double times[2];
    for (double& t : times) {
      t = anywhere(random);
      if (kind(random) == 0) t = std::round(t * 10.0) / 10.0;         // at a node
      if (kind(random) == 0) t = std::round(t * 10.0) / 10.0 + 3e-7;  // almost
      if (kind(random) == 0) t = infinity;
    }
    if (kind(random) == 0) times[1] = times[0];
    std::sort(std::begin(times), std::end(times));
    SCOPED_TRACE(::testing::Message() << "seed " << seed << " trial " << trial << " events "
                                      << times[0] << " " << times[1]);
    const Schedule schedule = schedule_at(times[0], times[1]);
    by_mode.set_schedule(schedule);
    by_event.set_schedule(schedule);
    expect_same_program(by_mode.nlp(), by_event.nlp(), random);
    if (HasFatalFailure()) return;
  }
}

TEST(ModeWindow, ActsInEveryOccurrenceOfItsMode) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.bound_input(0, exactly(0.0), during("swing"))
      .keep("stance", state, at_most(2.0), during("stance"))
      .keep("early stance", state, at_most(3.0),
            Window{.from = 0.1, .to = 0.7, .modes = {"stance"}});
  OptimalControlProblem ocp("walk");
  ocp.schedule(
         Schedule({"swing", "stance", "swing", "stance"}, {{"a", 0.15}, {"b", 0.3}, {"c", 0.65}})
             .reserve(5))
      .start_at({1})
      .then(phase);
  MultipleShooting shooting(ocp, ten);
  EXPECT_EQ(shooting.grid().intervals(0), 15);
  const auto expect_times = [&](const char* term, const Times& expected) {
    const Times given = active_times(shooting, term);
    ASSERT_EQ(given.size(), expected.size()) << term;
    for (std::size_t i = 0; i < given.size(); ++i) EXPECT_NEAR(given[i], expected[i], 1e-9);
  };
  // Includes the left limits of both stances, at 0.3 s and at the end.
  expect_times("stance", {0.15, 0.2, 0.3, 0.65, 0.7, 0.8, 0.9, 1.0});
  expect_times("early stance", {0.15, 0.2, 0.3, 0.65, 0.7});
  for (const InputBounds& b : input_bounds(shooting)) {
    const double middle = 0.5 * (b.from + b.to);
    EXPECT_EQ(b.bounds.is_equality(), middle < 0.15 || (middle > 0.3 && middle < 0.65)) << middle;
  }
  // With two more modes, the second swing is divided in two, and the last stance ends early.
  Schedule schedule = shooting.data().schedule;
  schedule.insert("stance", "stumble", 0.52);
  schedule.retime("c", 0.95);
  schedule.insert("swing", "recover", 0.6);
  shooting.set_schedule(schedule);
  expect_times("stance", {0.15, 0.2, 0.3, 0.52, 0.6, 0.95, 1.0});
  schedule.retime("c", 1.0);  // a mode that begins at the end of the horizon has a state there
  shooting.set_schedule(schedule);
  expect_times("stance", {0.15, 0.2, 0.3, 0.52, 0.6, 1.0});
  schedule.erase("b");  // one stance, then event "stumble" from stance to stance
  shooting.set_schedule(schedule);
  expect_times("stance", {0.15, 0.2, 0.3, 0.4, 0.5, 0.52, 0.6, 1.0});
}

TEST(ModeWindow, ConsecutiveModesHaveNoGap) {
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.minimise("time", one, during("a", "b"));
  OptimalControlProblem ocp("union");
  ocp.schedule(Schedule({"c", "a", "b", "c"}, {{"1", 0.13}, {"2", 0.4}, {"3", 0.77}}))
      .start_at({1})
      .then(phase);
  MultipleShooting shooting(ocp, ten);
  EXPECT_NEAR(cost_at(shooting, 1.0, 0.0), 0.77 - 0.13, 1e-12);
  shooting.retime("2", 0.77);
  EXPECT_NEAR(cost_at(shooting, 1.0, 0.0), 0.77 - 0.13, 1e-12);
  shooting.retime("1", 0.77 - 0.5 * same_instant);  // both are now empty
  EXPECT_EQ(cost_at(shooting, 1.0, 0.0), 0.0);
}

// --- rejected edits, and allocations
// -----------------------------------------------------------

TEST(LiveSchedule, RejectedEditsChangeNothing) {
  std::mt19937 random(3);
  MultipleShooting shooting = walking_problem(walking_schedule());
  MultipleShooting untouched = walking_problem(walking_schedule());
  const auto refused = [&](const Schedule& schedule, const std::string& fragment) {
    expect_error<DefinitionError>([&] { shooting.set_schedule(schedule); }, {fragment});
    expect_same_program(shooting.nlp(), untouched.nlp(), random);
  };
  Schedule without = walking_schedule();
  without.erase("goal");
  refused(without, "phase 'near', term 'late': its window refers to event 'goal'");
  Schedule more = walking_schedule().reserve(7);
  for (int i = 0; i < 5; ++i) more.insert("left", std::to_string(i), 0.1 * i);
  refused(more, "it has 7 events, but the declared capacity is 6");
  refused(Schedule({"left", "hop"}, {{"goal", 0.5}}), "there is no mode 'hop'");
}

TEST(LiveSchedule, RollsBackCrossedBounds) {
  std::mt19937 random(4);
  Phase<1, 1> phase{"motion", Velocity{}, exactly(1.0)};
  phase.bound_input(0, at_least(1.0), during("push"))
      .bound_input(0, at_most(0.0), Window{.to = 0.5});
  const Schedule sound = Schedule({"coast", "push"}, {{"start", 0.6}}).reserve(2);
  OptimalControlProblem ocp("excluding");
  ocp.schedule(sound).start_at({1}).then(phase);
  MultipleShooting shooting(ocp, ten), untouched(ocp, ten);
  Schedule early = sound;
  early.insert("push", "too early", 0.2);
  EXPECT_THROW(shooting.set_schedule(early), DefinitionError);
  EXPECT_FALSE(shooting.data().schedule.contains("too early"));
  expect_same_program(shooting.nlp(), untouched.nlp(), random);
}

TEST(LiveSchedule, NeitherSchedulesNorPenaltyAllocate) {
  std::mt19937 random(5);
  MultipleShooting shooting = walking_problem(walking_schedule());
  std::vector<Schedule> schedules{walking_schedule()};
  for (int i = 0; i < 50; ++i) {
    Schedule next = schedules.back();
    edit_at_random(next, 0.0, random);
    schedules.push_back(next);
  }
  const testing::AllocationCount count;
  for (const Schedule& schedule : schedules) {
    shooting.set_schedule(schedule);
    shooting.set_penalty_weight("lane", 10.0);
    shooting.set_penalty_weight("power", 3.0);
  }
  EXPECT_EQ(count.made(), 0);
}

}  // namespace
}  // namespace saltus
