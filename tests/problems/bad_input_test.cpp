// Messages of whole-body runs for invalid input: one sentence, exit status 2. A robot that falls is
// a result, status 0. Needs the URDF file named by SALTUS_ICUB_URDF.
#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "tests/app/support.hpp"
#include "tests/problems/push_recovery_program.hpp"

namespace saltus::push_recovery {
namespace {

class BadInput : public testing::Test {
 protected:
  void SetUp() override {
    const char* file = std::getenv("SALTUS_ICUB_URDF");
    if (file == nullptr) GTEST_SKIP() << "SALTUS_ICUB_URDF does not name iCubGazeboV2_5's URDF";
    urdf = file_content(file);
  }

  int run(const std::vector<std::string>& settings) {
    std::vector<std::string> words{"--plant", "dart",  "--pictures",
                                   "false",   "--out", (folder / "out").string()};
    words.insert(words.end(), settings.begin(), settings.end());
    ProgramRun program = run_program(words);
    printed = std::move(program.printed);
    complaint = std::move(program.complaint);
    return program.status;
  }

  void expect_refused(const std::vector<std::string>& settings, const std::string& part) {
    EXPECT_EQ(run(settings), 2) << printed;
    EXPECT_TRUE(contains(complaint, part));
    EXPECT_EQ(complaint.find('\n'), complaint.size() - 1) << "more than one line: " << complaint;
  }

  // The URDF with the first `old` after `from` replaced.
  std::string changed(const std::string& from, const std::string& old, const std::string& by) {
    const std::size_t at = urdf.find(old, urdf.find(from));
    EXPECT_NE(at, std::string::npos) << from << ", " << old;
    std::string text = urdf;
    return folder.file("changed.urdf", text.replace(at, old.size(), by)).string();
  }

  TemporaryFolder folder;
  std::string urdf, printed, complaint;
};

TEST_F(BadInput, RejectsAPostureOutsideTheLimitsOfAJoint) {
  const std::string joint = R"(<joint name="l_elbow")";
  expect_refused({"--urdf", changed(joint, R"(upper="1.8500490071139892")", R"(upper="0.7")")},
                 "has joint \"l_elbow\" at 0.7928 rad, outside its limits 0.2618 to 0.7 rad");
}

TEST_F(BadInput, RejectsAJointMissingFromTheUrdf) {
  expect_refused({"--urdf", changed(R"(<joint name="l_knee")", "l_knee", "l_nee")},
                 "there is no movable joint \"l_knee\"; did you mean \"l_nee\"?");
}

TEST_F(BadInput, RejectsAUrdfThatIsNotAFile) {
  expect_refused({"--urdf", (folder / "none.urdf").string()}, "there is no such file");
  expect_refused({"--urdf", folder.path().string()}, "this is not a file");
  expect_refused({"--urdf", folder.file("text.urdf", "not a robot").string()},
                 "this is not a URDF");
}

TEST_F(BadInput, RejectsAnUnknownLinkToPush) {
  expect_refused({"--push.link", "chast"}, "did you mean \"chest\"?");
}

// With a continuous knee joint, no reach can be computed.
TEST_F(BadInput, RejectsLegsWithoutJointLimitsForTheStepPlanner) {
  const std::string knee =
      changed(R"(<joint name="l_knee" type="revolute")", "revolute", "continuous");
  expect_refused({"--urdf", knee, "--step.planner", "ocp"},
                 "joint \"l_knee\" of a leg has no position limits, which determine the reach of "
                 "the feet; add them, or set step.reach=settings");
}

// The loop counts engine steps. A period of zero steps caused a division by zero.
TEST_F(BadInput, RejectsPeriodsThatAreNotMultiples) {
  expect_refused(
      {"--control.period", "0.0003"},
      "control.period (0.0003 s) must be a whole multiple of simulator.step_s (0.001 s)");
  expect_refused({"--simulator.step_s", "0.0015"}, "must be a whole multiple of simulator.step_s");
  expect_refused({"--control.period", "0.004"},
                 "mpc.step_s (0.01 s) must be a whole multiple of control.period (0.004 s)");
  expect_refused({"--mpc.step_s", "0.0004"}, "must be a whole multiple of control.period");
}

// With a torque delay of 60 ms, the robot falls before any push.
TEST_F(BadInput, ReportsAFallBeforeThePushAndKeepsResults) {
  EXPECT_EQ(run({"--simulator.delay_ticks", "30"}), 0) << complaint;
  EXPECT_TRUE(contains(printed, "before the push"));
  const auto summary = nlohmann::json::parse(file_content(folder / "out/summary.json"));
  EXPECT_FALSE(summary["recovered"].get<bool>());
  EXPECT_TRUE(summary["stopped_early"].get<bool>());
  EXPECT_TRUE(summary["fell_before_push"].get<bool>());
  EXPECT_TRUE(contains(summary["reason"].get<std::string>(), "before the push"));
  EXPECT_GT(file_content(folder / "out/body.csv").size(), 1000u);
}

}  // namespace
}  // namespace saltus::push_recovery
