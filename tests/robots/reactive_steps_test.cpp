// Contacts from a step plan, the rule that makes step plans, and lists of pushes.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "saltus/core/error.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/walking/contacts.hpp"
#include "saltus/robots/walking/push.hpp"
#include "saltus/robots/walking/reactive_steps.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus::robots::walking {
namespace {

constexpr double mass = 33.0, height = 0.53;

Scene on_two_feet() {
  Scene scene;
  scene.stance_foot = {between(-0.05, 0.1), between(-0.03, 0.04)};
  scene.swing_foot = scene.stance_foot.mirrored();
  scene.swing = flat_sole({0.0, -0.14, 0.0});
  scene.two_feet = true;
  return scene;
}

// CoM above the middle of the feet, with this capture point.
StepSituation with_capture_point(double x, double y, double t = 1.0) {
  StepSituation now;
  now.time = t;
  now.mass = mass;
  now.omega = pendulum_frequency(height);
  now.gamma << 0.02, -0.07, height, now.omega * (x - 0.02), now.omega * (y + 0.07),
      Vec<double, 4>::Zero();
  now.right.sole = flat_sole({0.0, -0.14, 0.0});
  return now;
}

Step following() {
  Step options;
  options.decision_lead = 0.1;
  options.decide = Step::Decision::if_it_helps;
  return options;
}

TEST(Contacts, FollowThePlanFromThePresentContacts) {
  Schedule contacts = two_feet_throughout(events_ahead);
  const std::array<StepPlan::Step, 2> steps{
      StepPlan::Step{.foot = Side::left, .lift_off = 1.0, .landing = 1.4},
      StepPlan::Step{.foot = Side::right, .lift_off = 1.5, .landing = 1.9}};
  const testing::AllocationCount count;
  schedule_contacts(contacts, true, true, steps);
  EXPECT_EQ(count.made(), 0);
  EXPECT_EQ(contacts.mode_at(0.9), double_support);
  EXPECT_EQ(contacts.mode_at(1.0), right_support);
  EXPECT_EQ(contacts.mode_at(1.4), double_support);
  EXPECT_EQ(contacts.mode_at(1.5), left_support);
  EXPECT_EQ(contacts.events().size(), 3u);  // there is no room for the second landing
  // The left foot is in the air already.
  schedule_contacts(contacts, false, true, steps);
  EXPECT_EQ(contacts.mode_at(0.0), right_support);
  EXPECT_EQ(landing_time(contacts), 1.4);
  schedule_contacts(contacts, true, true, {});
  EXPECT_EQ(landing_time(contacts), -infinity);
}

TEST(ReactiveSteps, StandsWhileTheCapturePointIsSupported) {
  ReactiveSteps steps(following(), on_two_feet());
  for (const double x : {-0.04, 0.0, 0.09})
    EXPECT_FALSE(steps.plan(with_capture_point(x, -0.07)).is_stepping()) << x;
}

TEST(ReactiveSteps, StepsToThePredictedCapturePoint) {
  for (const double direction : {1.0, -1.0}) {
    ReactiveSteps steps(following(), on_two_feet());
    const double x = direction > 0.0 ? 0.11 : -0.06;
    const testing::AllocationCount count;
    const StepPlan& plan = steps.plan(with_capture_point(x, -0.07));
    EXPECT_EQ(count.made(), 0);
    ASSERT_TRUE(plan.is_stepping());
    const StepPlan::Step& step = plan.steps[0];
    EXPECT_GT(direction * step.place[0], std::abs(x));
    EXPECT_GE(step.landing, step.lift_off + following().shortest - 1e-9);
    EXPECT_EQ(plan.alternatives, 3);  // either foot, and standing
    // Away from the foot that stays.
    const double stance_y = step.foot == Side::right ? 0.0 : -0.14;
    EXPECT_GE(std::abs(step.place[1] - stance_y), following().lateral_min - 1e-9);
  }
}

TEST(ReactiveSteps, LargerPushGivesAShorterStep) {
  double before = infinity;
  for (const double x : {0.105, 0.12, 0.14}) {
    ReactiveSteps steps(following(), on_two_feet());
    const StepPlan& plan = steps.plan(with_capture_point(x, -0.07));
    ASSERT_TRUE(plan.is_stepping());
    EXPECT_LE(plan.steps[0].landing, before);
    before = plan.steps[0].landing;
  }
}

TEST(ReactiveSteps, FollowsTheSwingFootUntilShortlyBeforeItsLanding) {
  ReactiveSteps steps(following(), on_two_feet());
  StepPlan plan = steps.plan(with_capture_point(0.11, -0.07));
  ASSERT_TRUE(plan.is_stepping());
  const StepPlan::Step first = plan.steps[0];
  const auto later = [&](double x, double t) {
    StepSituation now = with_capture_point(x, -0.07, t);
    now.foot(first.foot).stands = false;
    now.foot(first.foot).lifted_off = first.lift_off;
    return steps.plan(now);
  };
  plan = later(0.13, 1.05);
  EXPECT_EQ(plan.steps[0].foot, first.foot);
  EXPECT_GT(plan.steps[0].place[0], first.place[0]);
  EXPECT_LE(plan.steps[0].landing, first.landing);
  const StepPlan::Step fixed = plan.steps[0];
  plan = later(0.20, fixed.landing - 0.05);
  EXPECT_EQ(plan.steps[0].place, fixed.place);
  EXPECT_EQ(plan.steps[0].landing, fixed.landing);
}

TEST(Pushes, ListAddsToTheFirstPush) {
  MorePushes more;
  more.list = "5 6 90; 3.5 2 0 0.2";
  const std::vector<Push> pushes = all_pushes(Push{}, more);
  ASSERT_EQ(pushes.size(), 3u);
  EXPECT_EQ(pushes[0].start, Push{}.start);
  EXPECT_EQ(pushes[1].start, 3.5);
  EXPECT_EQ(pushes[1].duration, 0.2);
  EXPECT_NEAR(pushes[2].direction[1], 1.0, 1e-12);
}

// push.impulse=0 means that there is no first push. Its time then has no effect on other pushes.
TEST(Pushes, ZeroImpulseIsNoPush) {
  Push none;
  none.impulse = 0.0;
  EXPECT_EQ(all_pushes(none, {}).size(), 1u);
  MorePushes more;
  more.list = "3 7 270; 4 0 90; 2.45 5 0";
  const std::vector<Push> pushes = all_pushes(none, more);
  ASSERT_EQ(pushes.size(), 2u);
  EXPECT_EQ(pushes[0].start, 2.45);
  EXPECT_EQ(pushes[1].start, 3.0);
}

TEST(Pushes, RandomPushesKeepTheirDistanceAndAreSeeded) {
  MorePushes more;
  more.rate = 1.0 / 6.0;
  const std::vector<Push> pushes = all_pushes(Push{}, more), again = all_pushes(Push{}, more);
  ASSERT_EQ(pushes.size(), 10u);
  for (std::size_t i = 0; i < pushes.size(); ++i) {
    EXPECT_GE(pushes[i].impulse, 3.0);
    EXPECT_LE(pushes[i].impulse, 8.0);
    EXPECT_EQ(pushes[i].start, again[i].start);
    if (i > 0) {
      EXPECT_GE(pushes[i].start, pushes[i - 1].start + more.apart - 1e-9);
    }
  }
  EXPECT_LE(pushes.back().end(), more.until);
  more.seed = 2;
  EXPECT_NE(all_pushes(Push{}, more)[0].start, pushes[0].start);
}

TEST(Pushes, RandomPushesCoverTheirIntervals) {
  MorePushes more;
  more.rate = 1.0 / 6.0;
  more.until = 6000.0;  // s
  const std::vector<Push> pushes = all_pushes(Push{}, more);
  ASSERT_EQ(pushes.size(), 1000u);
  double sum = 0.0, squares = 0.0;
  Vec<double, 3> directions = Vec<double, 3>::Zero();
  for (const Push& push : pushes) {
    sum += push.impulse;
    squares += push.impulse * push.impulse;
    EXPECT_NEAR(push.direction.norm(), 1.0, 1e-12);
    EXPECT_EQ(push.direction[2], 0.0);
    directions += push.direction;
  }
  // Values of a uniform distribution. The tolerances are five standard deviations for the mean and
  // about as many for the variance.
  const double mean = sum / 1000.0, width = more.impulse[1] - more.impulse[0];
  EXPECT_NEAR(mean, 0.5 * (more.impulse[0] + more.impulse[1]), 5.0 * width / std::sqrt(12e3));
  EXPECT_NEAR(squares / 1000.0 - mean * mean, width * width / 12.0, 0.15 * width * width / 12.0);
  EXPECT_LT(directions.norm() / 1000.0, 5.0 / std::sqrt(1e3));
  // The middle push begins near the middle: of 1000 sorted times in 2000 s, it has a standard
  // deviation of 32 s.
  EXPECT_NEAR(pushes[500].start, 3000.0, 5.0 * 32.0);
}

TEST(Pushes, RejectsImpossiblePushes) {
  for (const char* list : {"5 6", "5 6 90 0.1 3", "5 six 90", "5 6 nan", "-1 6 90", "2.45 6 90"}) {
    MorePushes more;
    more.list = list;
    EXPECT_THROW(all_pushes(Push{}, more), InputError) << list;
  }
  MorePushes crowded;
  crowded.rate = 1.0;
  EXPECT_THROW(all_pushes(Push{}, crowded), InputError);
}

}  // namespace
}  // namespace saltus::robots::walking
