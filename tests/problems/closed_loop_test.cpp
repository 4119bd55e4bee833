// Is iCub caught by the step, and only by the step?
#include <gtest/gtest.h>

#include <cmath>

#include "problems/push_recovery/simulation.hpp"
#include "robots/icub/icub.hpp"

namespace saltus::push_recovery {
namespace {

// The push comes soon, so that the runs are short; everything else is the default.
Config pushed_by(double impulse) {
  Config config;
  config.push.impulse = impulse;
  config.push.start = 0.1;
  config.pictures = false;
  return config;
}

struct Outcome {
  RunLog log;
  Verdict verdict;
};

Outcome run(const Config& config) {
  Outcome outcome{simulate(config, icub()), {}};
  outcome.verdict = judge(config, outcome.log);
  return outcome;
}

void expect_every_solve_optimal(const RunLog& log) {
  for (const TickRecord& tick : log.ticks) {
    ASSERT_EQ(tick.status, SolveStatus::optimal) << tick.time << ": " << tick.message;
    // Our own residual; the solver's tolerance is 1e-8, scaled its own way.
    ASSERT_LT(tick.kkt, 1e-6) << tick.time;
  }
}

class StepRecovers : public testing::TestWithParam<double> {};

TEST_P(StepRecovers, FromThePush) {
  const Config config = pushed_by(GetParam());
  const Outcome outcome = run(config);
  EXPECT_TRUE(outcome.verdict.recovered) << outcome.verdict.reason;
  EXPECT_NEAR(outcome.log.touchdown, config.push.start + config.step.duration, 1e-9);
  expect_every_solve_optimal(outcome.log);
}

INSTANTIATE_TEST_SUITE_P(Impulses, StepRecovers, testing::Values(6.0, 8.0));

TEST(ClosedLoop, WithoutAStepEightNewtonSecondsAreAFall) {
  Config config = pushed_by(8.0);
  config.stepping = false;
  const Outcome outcome = run(config);
  EXPECT_FALSE(outcome.verdict.recovered);
  EXPECT_TRUE(outcome.log.stopped_early);
  EXPECT_EQ(outcome.log.touchdown, infinity);
  EXPECT_NE(outcome.verdict.reason.find("fell"), std::string::npos) << outcome.verdict.reason;
  expect_every_solve_optimal(outcome.log);  // a fall is not a failure of the solver
}

TEST(ClosedLoop, TheLandingNeedNotFallOnATick) {
  Outcome last;
  for (const double late : {0.0, 0.001, 0.0037, 0.009999}) {
    Config config = pushed_by(7.0);
    config.step.duration += late;
    Outcome outcome = run(config);
    ASSERT_TRUE(outcome.verdict.recovered) << late << ": " << outcome.verdict.reason;
    EXPECT_NEAR(outcome.log.touchdown, config.push.start + config.step.duration, 1e-9);
    if (late > 0.0) {
      // A few milliseconds later the robot has moved on a little, no more: the predicted place of
      // the foot, and half of that the target, shifts by omega x delay x distance to the sole's
      // edge, 6.3 ms x 4.2 / s x 0.2 m = 5 mm at the most.
      EXPECT_NEAR(outcome.verdict.angular_momentum_max, last.verdict.angular_momentum_max, 0.05);
      EXPECT_LT(
          (outcome.log.samples.back().gamma.head<3>() - last.log.samples.back().gamma.head<3>())
              .norm(),
          5e-3);
      EXPECT_NEAR(outcome.verdict.final_com_error, last.verdict.final_com_error, 1e-3);
    }
    last = std::move(outcome);
  }
}

TEST(ClosedLoop, SmallPushIsCaughtStanding) {
  const Outcome outcome = run(pushed_by(2.0));
  EXPECT_TRUE(outcome.verdict.recovered) << outcome.verdict.reason;
  EXPECT_EQ(outcome.log.touchdown, infinity);
}

TEST(StepLogic, TheTriggerIsThePushOrTheCapturePointAsAsked) {
  const FootRectangle foot{between(-0.05, 0.1), between(-0.03, 0.04)};
  for (const StepTrigger trigger : {StepTrigger::push, StepTrigger::icp}) {
    Step options;
    options.trigger = trigger;
    StepLogic logic(options, true, 1.0, SoleFrame{}, foot);
    logic.update(1.04, {0.0, -0.02}, 4.2);  // still over the sole
    EXPECT_FALSE(logic.is_stepping());
    logic.update(1.05, {0.0, -0.04}, 4.2);
    ASSERT_TRUE(logic.is_stepping());
    EXPECT_DOUBLE_EQ(logic.landing_time(), trigger == StepTrigger::push ? 1.6 : 1.65);
  }
}

TEST(StepLogic, ThePlaceIsThePredictedCapturePointWithinReachAndThenFixed) {
  const FootRectangle foot{between(-0.05, 0.1), between(-0.03, 0.04)};
  StepLogic logic(Step{}, true, 1.0, SoleFrame{}, foot);
  const double omega = 4.2;
  logic.update(1.1, {0.02, -0.05}, omega);
  ASSERT_TRUE(logic.is_decided());
  EXPECT_NEAR(logic.place()[0], 0.02, 1e-12);  // inside the sole fore and aft: nothing diverges
  EXPECT_NEAR(logic.place()[1], -0.03 - 0.02 * std::exp(omega * 0.5), 1e-12);
  logic.update(1.2, {0.02, -0.3}, omega);
  EXPECT_NEAR(logic.place()[1], -0.03 - 0.02 * std::exp(omega * 0.5), 1e-12);

  StepLogic far(Step{}, true, 1.0, SoleFrame{}, foot);
  far.update(1.1, {0.2, -0.2}, omega);
  EXPECT_DOUBLE_EQ(far.place()[0], 0.25);
  EXPECT_DOUBLE_EQ(far.place()[1], -0.30);
}

}  // namespace
}  // namespace saltus::push_recovery
