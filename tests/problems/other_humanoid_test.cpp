// Any humanoid from URDF and configuration file: a synthetic biped balances and is pushed in DART.
// Incomplete or invalid files are refused in one sentence, exit status 2.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "problems/push_recovery/push_recovery.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"
#include "tests/app/support.hpp"
#include "tests/problems/push_recovery_program.hpp"
#include "tests/robots/synthetic_biped.hpp"
#include "tests/support/errors.hpp"

namespace saltus::push_recovery {
namespace {

constexpr double rounding = 1e-5;  // the URDF is written with six digits

class OtherHumanoid : public testing::Test {
 protected:
  // Call `write` first. Settings: key, value, key, value ...
  int run(const std::vector<std::string>& settings) {
    std::map<std::string, std::string> given{{"--plant", "dart"},
                                             {"--preset", "paper"},
                                             {"--pictures", "false"},
                                             {"--push.start", "0.2"},
                                             {"--push.link", "trunk"},
                                             {"--out", (folder / "out").string()},
                                             {"--robot.config", config.string()},
                                             {"--robot.urdf", urdf.string()}};
    for (std::size_t i = 0; i + 1 < settings.size(); i += 2) given[settings[i]] = settings[i + 1];
    std::vector<std::string> words;
    for (const auto& [key, value] : given) words.insert(words.end(), {key, value});
    ProgramRun program = run_program(words);
    printed = std::move(program.printed);
    complaint = std::move(program.complaint);
    return program.status;
  }

  void write(const std::string& yaml, const std::string& urdf_text) {
    config = folder.file("robot.yaml", yaml);
    urdf = folder.file("robot.urdf", urdf_text);
  }

  void expect_refused(const std::string& yaml, const std::string& urdf_text,
                      const std::string& part, const std::vector<std::string>& settings = {}) {
    write(yaml, urdf_text);
    EXPECT_EQ(run(settings), 2) << printed;
    EXPECT_TRUE(contains(complaint, part));
    EXPECT_EQ(complaint.find('\n'), complaint.size() - 1) << "more than one line: " << complaint;
  }

  nlohmann::json summary() {
    return nlohmann::json::parse(file_content(folder / "out/summary.json"));
  }

  TemporaryFolder folder;
  std::filesystem::path config, urdf;
  std::string printed, complaint;
  SyntheticBiped biped;
};

std::string replaced(std::string text, const std::string& old, const std::string& by) {
  const std::size_t at = text.find(old);
  EXPECT_NE(at, std::string::npos) << old;
  return text.replace(at, old.size(), by);
}

// Homogeneous links: the box with the same inertia equals the drawn box.
TEST_F(OtherHumanoid, BoxesReplaceMeshesByTheInertia) {
  biped.feet_have_boxes = false;
  write(biped.yaml(), biped.urdf());
  Config given;
  given.robot.file = config.string();
  given.robot.urdf = urdf.string();
  const robots::FloatingRobot robot =
      robots::floating_robot(robots::UrdfModel::read(urdf), robot_of(given));
  EXPECT_EQ(robot.joints(), 14);
  for (const robots::FloatingRobot::Body& body : robot.bodies) {
    ASSERT_EQ(body.looks.size(), 1U) << body.name;
    const robots::FloatingRobot::Look& look = body.looks[0];
    ASSERT_EQ(look.boxes.size(), 1U) << body.name;
    const robots::UrdfModel::Box& box = look.boxes[0];
    Vec<double, 3> size = box.size, drawn = look.visuals.at(0).size;
    std::sort(size.begin(), size.end());
    std::sort(drawn.begin(), drawn.end());
    // Light links have smaller boxes with the same proportions.
    EXPECT_LE(size.prod(), drawn.prod() * (1.0 + rounding)) << body.name;
    EXPECT_LT((size.normalized() - drawn.normalized()).norm(), rounding) << body.name;
    EXPECT_LT((box.pose.translation() - body.com).norm(), rounding) << body.name;
    EXPECT_NEAR(box.pose.linear().determinant(), 1.0, rounding);
  }
}

TEST_F(OtherHumanoid, WithstandsASmallPush) {
  write(biped.yaml(), biped.urdf());
  ASSERT_EQ(run({"--push.impulse", "2", "--stepping", "false"}), 0) << complaint;
  EXPECT_EQ(complaint, "");
  const auto json = summary();
  EXPECT_TRUE(json["recovered"]) << json["reason"];
  EXPECT_EQ(json["robot"], "synthetic");
  EXPECT_NEAR(json["mass_kg"].get<double>(), 47.1, 1e-9);
  EXPECT_EQ(json["body"]["control_failures"], 0);
}

TEST_F(OtherHumanoid, RecoversWithAStep) {
  write(biped.yaml(), biped.urdf());
  ASSERT_EQ(run({"--push.impulse", "12", "--step.lateral_min", "0.16"}), 0) << complaint;
  const auto json = summary();
  EXPECT_TRUE(json["recovered"]) << json["reason"];
  EXPECT_NEAR(json["touchdown_s"].get<double>(), 0.8, 0.05);
}

TEST_F(OtherHumanoid, FeetWithoutBoxesUseTheRectanglesOfTheFile) {
  biped.feet_have_boxes = false;
  write(biped.yaml(), biped.urdf());
  ASSERT_EQ(run({"--push.impulse", "2", "--stepping", "false"}), 0) << complaint;
  EXPECT_TRUE(summary()["recovered"]) << summary()["reason"];
  EXPECT_TRUE(
      contains(complaint, "warning: " + urdf.string() + ": the feet have no collision box"));
  EXPECT_EQ(complaint.find('\n'), complaint.size() - 1) << complaint;
}

TEST_F(OtherHumanoid, RejectsFeetWithoutBoxesAndRectangles) {
  const std::string yaml = biped.yaml();
  biped.feet_have_boxes = false;
  expect_refused(yaml, biped.urdf(), "robot.yaml: left_foot is missing; add it, or a <collision>");
}

TEST_F(OtherHumanoid, DataComeFromTheFileOrTheUrdf) {
  write(biped.yaml(), biped.urdf());
  Config given;
  given.robot.file = config.string();
  expect_error<InputError>([&] { robot_of(given); }, {"mass is missing", "or name the URDF"});
  given.robot.urdf = urdf.string();
  EXPECT_NEAR(robot_of(given).mass, 47.1, 1e-9);
}

TEST_F(OtherHumanoid, NamesMissingData) {
  const std::string yaml = biped.yaml(), text = biped.urdf();
  expect_refused(replaced(yaml, "  knee of left leg", "  kne of left leg"), text,
                 "robot.urdf: there is no movable joint \"kne of left leg\"; did you mean "
                 "\"knee of left leg\"?");
  expect_refused(replaced(yaml, "left: sole of left foot", "left: sole of left hand"), text,
                 "robot.urdf: there is no link \"sole of left hand\"; did you mean \"sole of left "
                 "foot\"?");
  expect_refused(replaced(yaml, "base: pelvis", "bse: pelvis"), text,
                 "robot.yaml: bse is not a known key; did you mean \"base\"?");
  expect_refused(replaced(yaml, "base: pelvis\n", ""), text, "robot.yaml: base is missing");
  expect_refused(replaced(yaml, "base: pelvis", "base: pelves"), text,
                 "there is no link \"pelves\"; did you mean \"pelvis\"?");
  expect_refused(yaml, text.substr(0, text.size() / 2), "robot.urdf: the file is truncated");
  expect_refused(yaml, text, "has no posture on the right foot alone", {"--stance", "right"});
  expect_refused(yaml, text, "there is no link \"chest\"; the known names are",
                 {"--push.link", "chest"});
  expect_refused(yaml, text, "nothing.yaml: there is no such file",
                 {"--robot.config", (folder / "nothing.yaml").string()});
  expect_refused(yaml, text, "needs a URDF; give it with --robot.urdf FILE", {"--robot.urdf", ""});
  biped.knee_upper = 0.5;
  expect_refused(yaml, biped.urdf(),
                 "has joint \"knee of left leg\" at 0.6 rad, outside its limits");
}

}  // namespace
}  // namespace saltus::push_recovery
