// Does a second problem on a biped work without push recovery? This program does not link it.
#include "problems/sway/sway.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "saltus/app/settings.hpp"
#include "saltus/robots/icub/icub.hpp"
#include "saltus/robots/walking/closed_loop.hpp"

namespace saltus::sway {
namespace {

using namespace walking;

RunLog run(BipedProblem& problem, const std::vector<std::string>& words) {
  Settings settings;
  problem.declare(settings);
  std::vector<Assignment> assignments;
  for (const std::string& word : words) assignments.push_back(parse_set_argument(word));
  settings.apply(assignments);
  return simulate(problem, icub());
}

TEST(Sway, TheCentreOfMassGoesFromSideToSideOnBothFeet) {
  const auto problem = make_sway();
  const RunLog log = run(*problem, {"sway.amplitude=0.02", "sway.period=3", "sway.cycles=2"});
  EXPECT_TRUE(problem->judge(log).recovered) << problem->judge(log).reason;
  EXPECT_EQ(log.touchdown, infinity);
  for (const TickRecord& tick : log.ticks)
    ASSERT_EQ(tick.status, SolveStatus::optimal) << tick.time << ": " << tick.message;
  const double middle = 0.5 * (log.final_scene.stance.position + log.final_scene.swing.position)[1];
  double left = -infinity, right = infinity;
  for (const Sample& s : log.samples) {
    EXPECT_TRUE(s.two_feet());
    if (s.time < 3.0) continue;
    left = std::max(left, s.gamma[1] - middle);
    right = std::min(right, s.gamma[1] - middle);
  }
  constexpr double tracked = 2e-3;  // m
  EXPECT_NEAR(left, 0.02, tracked);
  EXPECT_NEAR(right, -0.02, tracked);
}

TEST(Sway, ASmallPushMeanwhileIsNoFall) {
  const auto problem = make_sway();
  const RunLog log = run(*problem, {"push.impulse=2", "push.start=1", "sway.cycles=2"});
  EXPECT_FALSE(log.stopped_early) << log.stop_reason;
  EXPECT_TRUE(problem->judge(log).recovered) << problem->judge(log).reason;
}

TEST(Sway, ARobotWithoutSuchAPostureIsRefused) {
  RobotDescription robot = icub();
  std::erase_if(robot.postures, [](const auto& p) { return p.stance == Stance::both; });
  EXPECT_THROW(simulate(*make_sway(), robot), InputError);
}

}  // namespace
}  // namespace saltus::sway
