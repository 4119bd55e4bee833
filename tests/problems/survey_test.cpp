#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "problems/biped/survey/foot_reach.hpp"
#include "problems/biped/survey/limbs.hpp"
#include "problems/biped/survey/posture_search.hpp"
#include "problems/biped/survey/robot_check.hpp"
#include "problems/biped/survey/robot_file.hpp"
#include "problems/biped/survey/robot_verb.hpp"
#include "problems/sway/sway.hpp"
#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"
#include "tests/app/support.hpp"
#include "tests/robots/synthetic_biped.hpp"
#include "tests/support/errors.hpp"

namespace saltus::survey {
namespace {

// A biped made of boxes, 1 m high, with joint names as on other robots: legs of hip pitch, hip
// roll, knee, ankle pitch, ankle roll; a waist, and arms whose axes are not mirrored.
class Biped {
 public:
  std::string soles = "_foot", effort = "80";
  const char *knee_axis = "0 1 0", *knee_lower = "0", *knee_upper = "2.4";
  double foot_height = 0.05;

  std::string urdf() const {
    std::string text = "<robot name=\"boxes\">" + link("pelvis", 10.0, 0.2, 0.0);
    text +=
        link("chest", 12.0, 0.3, 0.15) + joint("waist_yaw", "pelvis", "chest", "0 0 1", "0 0 0.1");
    return text + half(true) + half(false) + "</robot>";
  }

  robots::UrdfModel model() const { return robots::UrdfModel::parse(urdf(), "boxes.urdf"); }

 private:
  std::string half(bool left) const {
    const std::string side = left ? "left" : "right";
    const std::string y = left ? "0.1" : "-0.1";
    const auto name = [&](const char* part) { return part + ("_" + side); };
    return link(name("hip"), 1.0, 0.05, 0.0) +
           joint("leg_" + side + "_pitch", "pelvis", name("hip"), "0 1 0", "0 " + y + " 0") +
           link(name("thigh"), 3.0, 0.3, -0.2) +
           joint("leg_" + side + "_roll", name("hip"), name("thigh"), "1 0 0", "0 0 0") +
           link(name("shin"), 2.0, 0.3, -0.2) +
           joint("leg_" + side + "_knee", name("thigh"), name("shin"), knee_axis, "0 0 -0.4",
                 knee_lower, knee_upper) +
           link(name("ankle"), 0.2, 0.03, 0.0) +
           joint("leg_" + side + "_ankle_pitch", name("shin"), name("ankle"), "0 1 0", "0 0 -0.4") +
           "<link name=\"" + side + soles + "\">" + inertial(0.8, 0.1, -0.5 * foot_height) +
           "<collision><origin xyz=\"0.03 0 " + std::to_string(-0.5 * foot_height) +
           "\"/><geometry><box size=\"0.2 0.1 " + std::to_string(foot_height) +
           "\"/></geometry></collision></link>" +
           joint("leg_" + side + "_ankle_roll", name("ankle"), side + soles, "1 0 0", "0 0 0") +
           link(name("arm"), 2.0, 0.25, -0.15) +
           joint("arm_" + side + "_lift", "chest", name("arm"), "1 0 0",
                 "0 " + std::string(left ? "0.25" : "-0.25") + " 0.3") +
           link(name("finger"), 0.02, 0.02, 0.0) +
           joint("finger_" + side, name("arm"), name("finger"), "0 1 0", "0 0 -0.3");
  }
  static std::string inertial(double mass, double size, double z) {
    const std::string I = std::to_string(mass * size * size / 6.0);
    return "<inertial><origin xyz=\"0 0 " + std::to_string(z) + "\"/><mass value=\"" +
           std::to_string(mass) + "\"/><inertia ixx=\"" + I + "\" iyy=\"" + I + "\" izz=\"" + I +
           "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
  }
  static std::string link(const std::string& name, double mass, double size, double z) {
    return "<link name=\"" + name + "\">" + inertial(mass, size, z) + "</link>";
  }
  std::string joint(const std::string& name, const std::string& parent, const std::string& child,
                    const char* axis, const std::string& at, const char* lower = "-1.5",
                    const char* upper = "1.5") const {
    return "<joint name=\"" + name + "\" type=\"revolute\"><parent link=\"" + parent +
           "\"/><child link=\"" + child + "\"/><origin xyz=\"" + at + "\"/><axis xyz=\"" + axis +
           "\"/><limit lower=\"" + lower + "\" upper=\"" + upper + "\" effort=\"" + effort +
           "\" velocity=\"6\"/></joint>";
  }
};

bool holds(const std::vector<std::string>& list, const std::string& name) {
  return std::find(list.begin(), list.end(), name) != list.end();
}

template <class Act>
std::string complaint(const Act& act) {
  return error_of<InputError>(act, "");
}

std::vector<std::string> subjects(const std::vector<Finding>& findings, Finding::Level level) {
  std::vector<std::string> list;
  for (const Finding& f : findings)
    if (f.level == level) list.push_back(f.subject);
  return list;
}

std::vector<Finding> check(const robots::UrdfModel& model, const robots::RobotDescription& robot) {
  return check_robot(model, robot, 0.2, between(0.15, 0.3));
}

TEST(Limbs, FeetAreTheLowestBodies) {
  const Limbs limbs = find_limbs(Biped().model());
  EXPECT_EQ(limbs.left.sole, "left_foot");
  EXPECT_EQ(limbs.right.sole, "right_foot");
  EXPECT_NEAR(limbs.left.contact_plane_offset, -0.05, 1e-12);
  EXPECT_NEAR(limbs.left.rectangle.x.lower, -0.07, 1e-12);
  EXPECT_NEAR(limbs.left.rectangle.x.upper, 0.13, 1e-12);
  EXPECT_NEAR(limbs.left.origin.y(), 0.1, 1e-12);
}

TEST(Limbs, JointsIncludeLegsArmsAndTheirParents) {
  const Limbs limbs = find_limbs(Biped().model());
  EXPECT_EQ(limbs.joints.size(), 13u);
  EXPECT_EQ(limbs.legs.size(), 10u);
  EXPECT_TRUE(holds(limbs.joints, "waist_yaw"));
  EXPECT_TRUE(holds(limbs.joints, "arm_left_lift"));
  EXPECT_FALSE(holds(limbs.joints, "finger_left"));
  EXPECT_EQ(limbs.trunk, "chest");
}

TEST(Limbs, MirrorFindsNamesAndSigns) {
  const robots::RobotDescription::Mirror mirror = find_limbs(Biped().model()).mirror;
  EXPECT_EQ(mirror.namesake("leg_left_knee"), "leg_right_knee");
  EXPECT_EQ(mirror.namesake("leg_right_knee"), "leg_left_knee");
  EXPECT_EQ(mirror.namesake("waist_yaw"), "waist_yaw");
  // The axes are equal on both sides: mirroring keeps the sign of pitch and changes roll and yaw.
  for (const char* name : {"waist_yaw", "leg_left_roll", "leg_right_roll", "arm_left_lift"})
    EXPECT_TRUE(holds(mirror.reversed, name)) << name;
  for (const char* name : {"leg_left_pitch", "leg_right_knee", "leg_left_ankle_pitch"})
    EXPECT_FALSE(holds(mirror.reversed, name)) << name;
}

TEST(Limbs, NamesMissingPartsWithTheirRemedy) {
  Biped weak;
  weak.effort = "0";
  EXPECT_TRUE(contains(complaint([&] { find_limbs(weak.model()); }), "has no motor"));
  const auto one = robots::UrdfModel::parse(
      "<robot name=\"stick\"><link name=\"stick\"><inertial><mass value=\"1\"/><inertia ixx=\"1\" "
      "iyy=\"1\" izz=\"1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link></robot>",
      "stick.urdf");
  EXPECT_TRUE(contains(complaint([&] { find_limbs(one); }), "form left and right pairs"));
}

double distance(const robots::RobotDescription::LinkCapsule& limb, const Vec<double, 3>& point) {
  const robots::Capsule& c = limb.capsule;
  const Vec<double, 3> along = c.to - c.from;
  const double length = along.squaredNorm();
  const double s = length > 0.0 ? std::clamp((point - c.from).dot(along) / length, 0.0, 1.0) : 0.0;
  return (point - c.from - s * along).norm() - c.radius;
}

TEST(Capsules, ContainTheVisualShapeOrTheInertiaBox) {
  const Biped biped;
  const robots::UrdfModel model = biped.model();
  robots::RobotDescription robot = survey_robot(model).description;
  robot.capsules.clear();
  robots::FloatingRobot body = robots::floating_robot(model, robot);
  robots::add_capsules(body, model, robot);
  const auto expect_inside = [&](const char* link, const Vec<double, 3>& middle,
                                 const Vec<double, 3>& size) {
    const robots::FloatingRobot::Frame frame = robots::link_frame(body, model, link);
    const auto& capsules = body.bodies[static_cast<std::size_t>(frame.body)].capsules;
    ASSERT_FALSE(capsules.empty()) << link;
    for (int corner = 0; corner < 8; ++corner) {
      const Vec<double, 3> half(corner & 1 ? 0.5 : -0.5, corner & 2 ? 0.5 : -0.5,
                                corner & 4 ? 0.5 : -0.5);
      const Vec<double, 3> point = frame.pose * (middle + half.cwiseProduct(size));
      double nearest = infinity;
      for (const robots::RobotDescription::LinkCapsule& c : capsules)
        nearest = std::min(nearest, distance(c, point));
      EXPECT_LT(nearest, 1e-6) << link << " " << corner;  // m, accuracy of the fit
    }
  };
  expect_inside("left_foot", {0.03, 0.0, -0.5 * biped.foot_height}, {0.2, 0.1, biped.foot_height});
  // For a light link the box is smaller than the cube, but at least half as large.
  expect_inside("thigh_left", {0.0, 0.0, -0.2}, {0.1, 0.1, 0.1});
  expect_inside("chest", {0.0, 0.0, 0.15}, {0.2, 0.2, 0.2});

  const auto apart = [&](const char* first, const char* second) {
    std::pair<int, int> pair{robots::link_frame(body, model, first).body,
                             robots::link_frame(body, model, second).body};
    if (pair.first > pair.second) std::swap(pair.first, pair.second);
    return std::find(body.apart.begin(), body.apart.end(), pair) != body.apart.end();
  };
  EXPECT_TRUE(apart("left_foot", "right_foot"));
  EXPECT_TRUE(apart("shin_left", "chest"));
  EXPECT_FALSE(apart("thigh_left", "shin_left"));  // joined
}

TEST(PostureSearch, ReachesTheRequestedFeetAndCentreOfMass) {
  const robots::UrdfModel model = Biped().model();
  const robots::RobotDescription robot = survey_robot(model).description;
  robots::FloatingRobot body = robots::floating_robot(model, robot);
  robots::add_capsules(body, model, robot);
  PostureWish wish;
  wish.stance = robots::Side::left;
  wish.other_foot = {0.1, -0.25, 0.03};
  wish.com = {0.03, -0.01};
  wish.trunk_height = 0.78;
  const FoundPosture found = find_posture(model, robot, body, wish, {});
  EXPECT_TRUE(found.is_found());
  // Verified with the model's own kinematics.
  Eigen::Isometry3d other = model.link_pose("right_foot", "left_foot", found.joints);
  other.translate(Vec<double, 3>(0.0, 0.0, robot.contact_plane_offset));
  const Vec<double, 3> to_contact(0.0, 0.0, robot.contact_plane_offset);
  EXPECT_LT((other.translation() - to_contact - wish.other_foot).norm(), 1e-4);
  const Vec<double, 3> com = model.centre_of_mass("left_foot", found.joints);
  EXPECT_LT((com.head<2>() - wish.com).norm(), 1e-3);
  wish.other_foot.x() = 1.5;  // longer than the legs
  EXPECT_FALSE(find_posture(model, robot, body, wish, {}).is_found());
}

// The search starts from the posture on both feet, even if other postures precede it.
TEST(FootReach, SearchesFromTheStandingPostureAndWritesAtomically) {
  namespace fs = std::filesystem;
  const robots::UrdfModel model = robots::UrdfModel::parse(SyntheticBiped().urdf(), "biped.urdf");
  robots::RobotDescription robot = survey_robot(model).description;
  const TemporaryFolder folder;
  const robots::StandingPosture both = walking::posture_on_both_feet(robot);
  robot.postures = {robot.posture_on(robots::Side::left)};
  EXPECT_FALSE(cached_foot_reach(model, robot, folder.path()));
  EXPECT_TRUE(fs::is_empty(folder.path()));

  robot.postures = {both};
  const auto found = cached_foot_reach(model, robot, folder.path());
  ASSERT_TRUE(found);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
  // A folder has the name of the file: the reach is printed, and no partial file remains.
  const fs::path file = fs::directory_iterator(folder.path())->path();
  fs::remove(file);
  fs::create_directories(file / "taken");
  const auto again = cached_foot_reach(model, robot, folder.path());
  ASSERT_TRUE(again);
  EXPECT_EQ(again->from_foot, found->from_foot);
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), {}), 1);
}

TEST(SurveyedRobot, WritesAFileThatPassesItsCheck) {
  const robots::UrdfModel model = Biped().model();
  const SurveyedRobot robot = survey_robot(model);
  const robots::RobotDescription read = describe(
      model, robots::parse_robot_description(to_yaml(robot, model), "robot.yaml",
                                             robots::RobotDescription::Figures::from_urdf));
  ASSERT_EQ(read.postures.size(), 3u);
  EXPECT_EQ(read.joints.size(), 13u);
  EXPECT_NEAR(read.mass, 40.04, 1e-9);
  for (std::size_t i = 0; i < 3; ++i)
    EXPECT_LT((read.postures[i].com - robot.description.postures[i].com).norm(), 1e-5);
  const std::vector<Finding> findings = check(model, read);
  EXPECT_TRUE(subjects(findings, Finding::Level::wrong).empty()) << describe(findings);
  // The file contains the figures, for use without the URDF.
  EXPECT_NEAR(robots::parse_robot_description(to_yaml(robot, model), "robot.yaml").mass, 40.04,
              1e-6);
}

TEST(RobotCheck, ReportsErrors) {
  const robots::UrdfModel model = Biped().model();
  const robots::RobotDescription good = survey_robot(model).description;
  const auto wrong = [&](const robots::RobotDescription& robot) {
    return subjects(check(model, robot), Finding::Level::wrong);
  };
  EXPECT_TRUE(wrong(good).empty());
  robots::RobotDescription stilts = good;
  stilts.contact_plane_offset -= 0.0105;
  EXPECT_TRUE(holds(wrong(stilts), "feet"));
  robots::RobotDescription falls = good;
  falls.postures[0].com.y() -= 0.2;
  EXPECT_TRUE(holds(wrong(falls), "left_stance"));
  robots::RobotDescription bent = good;
  bent.postures[1].joints["leg_right_knee"] = -0.5;
  EXPECT_TRUE(holds(wrong(bent), "right_stance"));
  robots::RobotDescription idle = good;
  idle.joints[0].effort = 0.0;
  EXPECT_TRUE(holds(wrong(idle), "masses"));  // no valid body
  robots::RobotDescription strong = good;
  strong.joints[0].effort = 50000.0;
  EXPECT_TRUE(holds(subjects(check(model, strong), Finding::Level::note), "limits"));
}

// Each edge of a foot, moved by more and by less than the threshold. Postures have no effect here.
TEST(RobotCheck, ReportsAsymmetricFeet) {
  const robots::UrdfModel model = Biped().model();
  robots::RobotDescription robot = survey_robot(model).description;
  robot.postures.clear();
  const auto is_noted = [&](Bounds robots::FootRectangle::*axis, bool upper, double by) {
    robots::RobotDescription other = robot;
    (upper ? (other.right_foot.*axis).upper : (other.right_foot.*axis).lower) += by;
    return holds(subjects(check(model, other), Finding::Level::note), "feet");
  };
  for (const auto axis : {&robots::FootRectangle::x, &robots::FootRectangle::y})
    for (const bool upper : {false, true})
      for (const double sign : {-1.0, 1.0}) {
        EXPECT_TRUE(is_noted(axis, upper, 2e-3 * sign)) << upper << sign;
        EXPECT_FALSE(is_noted(axis, upper, 5e-4 * sign)) << upper << sign;
      }
}

TEST(RobotCheck, PrintsALineForEachFinding) {
  const std::vector<Finding> findings{{Finding::Level::good, "masses", "33.06 kg"},
                                      {Finding::Level::note, "limits", "none"},
                                      {Finding::Level::wrong, "left_stance", "falls"}};
  EXPECT_EQ(describe(findings),
            "ok    masses        33.06 kg\n"
            "note  limits        none\n"
            "WRONG left_stance   falls\n");
}

// The same legs with reversed knee axes.
TEST(SurveyedRobot, KneesBendWithinTheirLimits) {
  Biped backwards;
  backwards.knee_axis = "0 -1 0";
  backwards.knee_lower = "-2.4";
  backwards.knee_upper = "0";
  const robots::RobotDescription robot = survey_robot(Biped().model()).description,
                                 image = survey_robot(backwards.model()).description;
  constexpr double rounding = 1e-6;  // rad, rounding of the result
  for (std::size_t i = 0; i < robot.postures.size(); ++i)
    for (const char* knee : {"leg_left_knee", "leg_right_knee"}) {
      const double q = robot.postures[i].joints.at(knee);
      EXPECT_GT(q, 0.0) << knee;
      EXPECT_NEAR(image.postures[i].joints.at(knee), -q, rounding) << knee;
    }
}

// Half a radian the other way is less than a quarter of the range.
TEST(SurveyedRobot, LoadedKneeBendsTowardsItsLargerRange) {
  Biped loose;
  loose.knee_lower = "-0.5";
  for (const robots::StandingPosture& posture : survey_robot(loose.model()).description.postures) {
    if (posture.stance == robots::Stance::both) continue;
    const char* knee = posture.stance == robots::Stance::left ? "leg_left_knee" : "leg_right_knee";
    EXPECT_GT(posture.joints.at(knee), 0.0) << posture.name;
  }
}

TEST(RobotVerb, PrintsUsageWithoutArguments) {
  const Verb robot = robot_verb("walk", *sway::make_sway());
  for (const std::vector<std::string>& words :
       {std::vector<std::string>{}, {"--help"}, {"new", "--help"}}) {
    testing::internal::CaptureStdout();
    EXPECT_EQ(robot.run(words), ExitStatus::ok);
    EXPECT_TRUE(contains(testing::internal::GetCapturedStdout(), "saltus robot new FILE.urdf"));
  }
}

// G1, Talos and JVRC1 of the packages example-robot-data and jvrc-description, if a variable names
// the folder of their URDFs.
TEST(SurveyedRobot, FindsPosturesOfOtherHumanoids) {
  const char* files = std::getenv("SALTUS_FOREIGN_URDFS");
  if (files == nullptr) GTEST_SKIP() << "SALTUS_FOREIGN_URDFS names no files";
  std::istringstream list(files);
  for (std::string file; std::getline(list, file, ':');) {
    const robots::UrdfModel model = robots::UrdfModel::read(file);
    const std::vector<Finding> findings = check(model, survey_robot(model).description);
    EXPECT_TRUE(subjects(findings, Finding::Level::wrong).empty()) << file << describe(findings);
  }
}

}  // namespace
}  // namespace saltus::survey
