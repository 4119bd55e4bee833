// A second problem on a biped works without push recovery, which this program does not link.
#include "problems/sway/sway.hpp"

#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstddef>
#include <string>
#include <vector>

#include "problems/biped/report/run_summary.hpp"
#include "problems/biped/survey/robot_verb.hpp"
#include "saltus/app/program.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/core/error.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/robots/icub/icub.hpp"
#include "saltus/robots/simulation/simulate.hpp"
#include "tests/support/errors.hpp"

namespace saltus::sway {
namespace {

using namespace robots::walking;

RunLog run(ConfigurableBiped& problem, const std::vector<std::string>& words) {
  Settings settings;
  problem.declare(settings);
  std::vector<Assignment> assignments;
  for (const std::string& word : words) assignments.push_back(parse_set_argument(word));
  settings.apply(assignments);
  return simulate(problem, icub());
}

TEST(Sway, CentreOfMassSwaysOnBothFeet) {
  const auto problem = make_sway();
  const RunLog log = run(*problem, {"sway.amplitude=0.02", "sway.period=3", "sway.cycles=2"});
  EXPECT_TRUE(problem->judge(log).recovered) << problem->judge(log).reason;
  EXPECT_EQ(log.touchdown, infinity);
  for (const LoopLog::Tick& tick : log.ticks)
    ASSERT_EQ(tick.status, SolveStatus::optimal) << tick.time << ": " << tick.message;
  const double middle = 0.5 * (log.final_scene.stance.position + log.final_scene.swing.position)[1];
  double left = -infinity, right = infinity;
  for (const BipedSample& s : log.samples) {
    EXPECT_TRUE(s.two_feet());
    if (s.time < 3.0) continue;
    left = std::max(left, s.gamma[1] - middle);
    right = std::min(right, s.gamma[1] - middle);
  }
  constexpr double tracked = 2e-3;  // m
  EXPECT_NEAR(left, 0.02, tracked);
  EXPECT_NEAR(right, -0.02, tracked);
}

TEST(Sway, WithstandsASmallPush) {
  const auto problem = make_sway();
  const RunLog log = run(*problem, {"push.impulse=2", "push.start=1", "sway.cycles=2"});
  EXPECT_FALSE(log.stopped_early) << log.stop_reason;
  EXPECT_TRUE(problem->judge(log).recovered) << problem->judge(log).reason;
}

TEST(Sway, RejectsARobotWithoutTheStandingPosture) {
  robots::RobotDescription robot = icub();
  std::erase_if(robot.postures, [](const auto& p) { return p.stance == robots::Stance::both; });
  EXPECT_THROW(simulate(*make_sway(), robot), InputError);
}

TEST(Sway, SummaryCountsEveryTickOnce) {
  const auto problem = make_sway();
  const RunLog log = run(*problem, {"sway.period=3", "sway.cycles=1"});
  const auto file = summary(problem->settings(), log, problem->judge(log));
  const auto& counted = file.at("provenance");
  EXPECT_EQ(counted.size(), static_cast<std::size_t>(provenances));  // a name for each
  std::size_t ticks = 0;
  for (const auto& [name, count] : counted.items()) {
    EXPECT_FALSE(name.empty());
    ticks += count.get<std::size_t>();
  }
  EXPECT_EQ(ticks, log.ticks.size());
}

// `saltus robot` with this problem as the target of the settings.
TEST(RobotVerb, RejectsInvalidArguments) {
  const Verb robot = survey::robot_verb("sway", *make_sway());
  const auto refused = [&](const std::vector<std::string>& words) {
    return error_of<InputError>([&] { robot.run(words); });
  };
  const auto says = [](const std::string& text, const char* part) {
    return text.find(part) != std::string::npos;
  };
  EXPECT_PRED2(says, refused({"mend", "a.urdf"}), "use check, new, serve or play");
  EXPECT_PRED2(says, refused({"check"}), "needs the URDF of the robot");
  EXPECT_PRED2(says, refused({"new"}), "needs the URDF of the robot");
  EXPECT_PRED2(says, refused({"check", "a.urdf", "--out", "b"}), "--out belongs to `robot new`");
  EXPECT_PRED2(says, refused({"new", "a.urdf", "--config", "b"}),
               "--config belongs to `robot check`");
  // Valid arguments, but the file does not exist.
  EXPECT_PRED2(says, refused({"check", "absent.urdf"}), "absent.urdf");
  EXPECT_PRED2(says, refused({"check", "absent.urdf", "--config", "b"}), "absent.urdf");
  EXPECT_PRED2(says, refused({"new", "absent.urdf"}), "absent.urdf");
  EXPECT_PRED2(says, refused({"new", "absent.urdf", "--out", "b"}), "absent.urdf");
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{}, {"--help"}, {"check", "--help"}})
    EXPECT_EQ(robot.run(words), ExitStatus::ok);
}

}  // namespace
}  // namespace saltus::sway
