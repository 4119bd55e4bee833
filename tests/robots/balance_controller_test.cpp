// The balance controller, driven by recorded sensor data: neither a simulator nor the application
// is linked. biped_simulation_test.cpp makes the recording.
#include "saltus/robots/walking/balance_controller.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <thread>

#include "saltus/core/error.hpp"
#include "tests/robots/recorded_run.hpp"
#include "tests/robots/synthetic_balance.hpp"
#include "tests/robots/tree_dynamics.hpp"
#include "tests/support/count_allocations.hpp"

namespace saltus::robots::walking {
namespace {

class RecordedRun : public ::testing::Test {
 protected:
  RecordedRun() : lines(read_recorded_run(SALTUS_RECORDED_RUN, biped.robot.joints())) {}

  BalanceController controller() const {
    return biped.controller(std::make_unique<TreeDynamics>(biped.robot), biped.sensor_estimator());
  }

  SyntheticBalance biped;
  std::vector<RecordedLine> lines;
};

// The recording has nine digits and was made with DART. Torques of up to 50 Nm differ by 7e-5 Nm at
// the landing. The tolerance is four times that.
TEST_F(RecordedRun, MatchesTheRecording) {
  ASSERT_EQ(lines.size(), 250u);
  BalanceController c = controller();
  c.start(biped.start, lines.front().readings);
  int landings = 0;
  for (const RecordedLine& line : lines) {
    const Robot::Commands& commands = c.update(line.readings);
    EXPECT_LT((commands.torques - line.torques).lpNorm<Eigen::Infinity>(), 3e-4)
        << line.readings.time;
    EXPECT_EQ(c.last().has_landed, line.has_landed) << line.readings.time;
    landings += c.last().has_landed ? 1 : 0;
  }
  EXPECT_EQ(landings, 1);
  EXPECT_TRUE(c.planner().stands(Side::right));
  EXPECT_EQ(c.statistics().failures, 0);
}

// A force that does not come from the ground, 30 ms before the foot touches it. After the true
// landing the foot bounces once.
TEST_F(RecordedRun, ContinuesTheStepAfterAFalseContact) {
  BalanceController::Options options = biped.options();
  options.support.is_estimated = options.contact.is_estimated = true;
  BalanceController c(
      biped.parts(std::make_unique<TreeDynamics>(biped.robot), biped.sensor_estimator()), options);
  const auto touches = std::find_if(lines.begin(), lines.end(),
                                    [](const RecordedLine& line) { return line.has_landed; });
  ASSERT_NE(touches, lines.end());
  const double landing = touches->readings.time, at = landing - 0.03;
  c.start(biped.start, lines.front().readings);
  std::vector<double> landings, losses;
  for (RecordedLine& line : lines) {
    const double t = line.readings.time;
    if (t >= at && t < at + 0.01) line.readings.right[2] += 100.0;
    const saltus::testing::AllocationCount count;
    c.update(line.readings);
    ASSERT_EQ(count.made(), 0) << t;
    if (c.last().has_landed) landings.push_back(t);
    if (c.last().has_lost) losses.push_back(t);
  }
  ASSERT_EQ(landings.size(), 3u);
  ASSERT_EQ(losses.size(), 2u);
  EXPECT_NEAR(landings[0], at, 2e-3);
  EXPECT_NEAR(losses[0], at + 0.01 + options.contact.grace, 3e-3);
  EXPECT_NEAR(landings[1], landing, 3e-3);
  EXPECT_GT(losses[1], landings[1]);
  EXPECT_TRUE(c.planner().stands(Side::right));
}

// The ground is higher than expected and carries little at first. Once the foot has landed, height
// and time do not speak against the contact any more.
TEST_F(RecordedRun, KeepsAWeakContactAfterAnEarlyLanding) {
  BalanceController::Options options = biped.options();
  options.support.is_estimated = options.contact.is_estimated = true;
  BalanceController c(
      biped.parts(std::make_unique<TreeDynamics>(biped.robot), biped.sensor_estimator()), options);
  const auto touches = std::find_if(lines.begin(), lines.end(),
                                    [](const RecordedLine& line) { return line.has_landed; });
  ASSERT_NE(touches, lines.end());
  const double landing = touches->readings.time, at = landing - 0.04;
  c.start(biped.start, lines.front().readings);
  int landings = 0;
  for (RecordedLine& line : lines) {
    const double t = line.readings.time;
    if (t >= landing) break;
    if (t >= at) line.readings.right[2] += t < at + 3e-3 ? 100.0 : 30.0;
    c.update(line.readings);
    landings += c.last().has_landed;
    EXPECT_FALSE(c.last().has_lost) << t;
  }
  EXPECT_EQ(landings, 1);
}

// The clock of a robot need not begin at zero. Both controllers receive the same rounded times,
// because rounding decides at thresholds.
TEST_F(RecordedRun, IsIndependentOfTheZeroOfTheClock) {
  constexpr double zero = 1e6;  // s
  BalanceController from_zero = controller(), shifted = controller();
  for (std::size_t k = 0; k < lines.size(); ++k) {
    Robot::Readings late = lines[k].readings, early = late;
    late.time += zero;
    early.time = late.time - zero;
    if (k == 0) {
      from_zero.start(biped.start, early);
      shifted.start(biped.start, late);
    }
    if (k % 10 == 0) shifted.prepare(late.time);
    EXPECT_EQ(shifted.update(late).torques, from_zero.update(early).torques) << k;
    EXPECT_EQ(shifted.last().has_landed, from_zero.last().has_landed) << k;
    EXPECT_EQ(shifted.last().time, late.time) << k;
  }
  EXPECT_TRUE(shifted.planner().stands(Side::right));
  EXPECT_GE(shifted.planner().planner().controller().statistics().prepared_ahead, 23);
}

TEST_F(RecordedRun, PartsRunAtSeparateRates) {
  BalanceController c = controller();
  c.start(biped.start, lines.front().readings);
  for (std::size_t k = 0; k < 40; ++k) {
    c.update(lines[k].readings);
    EXPECT_EQ(c.last().has_controlled, k % 2 == 0) << k;
    EXPECT_EQ(c.last().has_planned, k % 10 == 0) << k;
  }
  EXPECT_EQ(c.statistics().calls, 20);
}

TEST_F(RecordedRun, DoesNotAllocate) {
  BalanceController c = controller();
  c.start(biped.start, lines.front().readings);
  for (const RecordedLine& line : lines) {
    const saltus::testing::AllocationCount count;
    c.update(line.readings);
    ASSERT_EQ(count.made(), 0) << line.readings.time;
  }
}

// The first correction uses forces of 0.05 s, after the robot has been quiet for 0.15 s, and after
// it has stayed quiet for 0.05 s.
TEST_F(RecordedRun, StartsWithTheDescribedMass) {
  BalanceController::Parts parts = biped.parts(nullptr, biped.sensor_estimator());
  parts.corrected = std::make_unique<CorrectedModel>(std::make_unique<TreeDynamics>(biped.robot),
                                                     biped.robot, MassEstimateOptions{});
  BalanceController corrected(std::move(parts), biped.options()), c = controller();
  c.start(biped.start, lines.front().readings);
  corrected.start(biped.start, lines.front().readings);
  ASSERT_NE(corrected.corrected_model(), nullptr);
  EXPECT_EQ(c.corrected_model(), nullptr);
  for (const RecordedLine& line : lines) {
    const saltus::testing::AllocationCount count;
    const Robot::Commands& commands = corrected.update(line.readings);
    ASSERT_EQ(count.made(), 0) << line.readings.time;
    if (line.readings.time >= 0.2) continue;
    ASSERT_EQ(commands.torques, c.update(line.readings).torques) << line.readings.time;
  }
}

// The torques equal those of a single thread, and neither thread allocates.
TEST_F(RecordedRun, DoesNotAllocateWithAPreparingThread) {
  BalanceController alone = controller(), c = controller();
  alone.start(biped.start, lines.front().readings);
  c.start(biped.start, lines.front().readings);
  constexpr int idle = -1, end = -2;
  std::atomic<int> asked{idle};  // line whose tick the other thread prepares
  std::thread other([&] {
    for (int k = idle; k != end; asked.wait(k), k = asked) {
      if (k == idle) continue;
      c.prepare(lines[static_cast<std::size_t>(k)].readings.time);
      asked = idle;
      asked.notify_all();
      k = idle;
    }
  });
  long made = 0;
  for (std::size_t k = 0; k < lines.size(); ++k) {
    const saltus::testing::AllocationCount count;
    if (k % 10 == 0) {
      asked = static_cast<int>(k);
      asked.notify_all();
      asked.wait(static_cast<int>(k));
    }
    const Robot::Commands& commands = c.update(lines[k].readings);
    made += count.made();
    EXPECT_EQ(commands.torques, alone.update(lines[k].readings).torques) << k;
  }
  asked = end;
  asked.notify_all();
  other.join();
  EXPECT_EQ(made, 0);
  // All of 25 ticks except the first and the one after the landing, which changes the schedule.
  EXPECT_GE(c.planner().planner().controller().statistics().prepared_ahead, 23);
}

TEST_F(RecordedRun, RejectsInvalidPartsAndPeriods) {
  const auto parts = [&] {
    return biped.parts(std::make_unique<TreeDynamics>(biped.robot), biped.sensor_estimator());
  };
  BalanceController::Parts missing = parts();
  missing.model.reset();
  EXPECT_THROW(BalanceController(std::move(missing), biped.options()), DefinitionError);
  BalanceController::Options options = biped.options();
  options.control_period = 0.0015;
  EXPECT_THROW(BalanceController(parts(), options), DefinitionError);
  options = biped.options();
  options.planner_period = 0.0;
  EXPECT_THROW(BalanceController(parts(), options), DefinitionError);
}

TEST_F(RecordedRun, IdealEstimatorRejectsMeasuredReadings) {
  const std::unique_ptr<Estimator> estimator = make_ideal_estimator();
  EXPECT_THROW(estimator->update(lines.front().readings), DefinitionError);
}

}  // namespace
}  // namespace saltus::robots::walking
