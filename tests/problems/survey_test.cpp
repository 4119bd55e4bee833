#include <fmt/format.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <sstream>
#include <string>
#include <vector>

#include "problems/biped/survey/foot_reach.hpp"
#include "problems/biped/survey/leg.hpp"
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
  double foot_height = 0.05, foot_mass = 0.8, foot_inertia_size = 0.1;  // m, kg, m
  double mass_unit = 1.0;                                               // kg

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
           "<link name=\"" + side + soles + "\">" +
           inertial(foot_mass, foot_inertia_size, -0.5 * foot_height) +
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
  std::string inertial(double mass, double size, double z) const {
    mass *= mass_unit;
    const std::string I = fmt::format("{:.9g}", mass * size * size / 6.0);
    return "<inertial><origin xyz=\"0 0 " + std::to_string(z) + "\"/><mass value=\"" +
           fmt::format("{:.9g}", mass) + "\"/><inertia ixx=\"" + I + "\" iyy=\"" + I + "\" izz=\"" +
           I + "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
  }
  std::string link(const std::string& name, double mass, double size, double z) const {
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

// Replaces the first `from` after the first `after`.
std::string edited(std::string text, const std::string& after, const std::string& from,
                   const std::string& to) {
  const std::size_t at = text.find(from, text.find(after));
  EXPECT_NE(at, std::string::npos) << after << " " << from;
  return text.replace(at, from.size(), to);
}

robots::UrdfModel model_of(const std::string& urdf) {
  return robots::UrdfModel::parse(urdf, "boxes.urdf");
}

std::string with_word(std::string text, const std::string& from, const std::string& to) {
  for (std::size_t at = 0; (at = text.find(from, at)) != std::string::npos; at += to.size())
    text.replace(at, from.size(), to);
  return text;
}

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

// Two arms of three joints, down to boxes below the feet. `names` are those of the joints.
std::string long_arms(const std::array<const char*, 3>& names) {
  std::string text;
  for (const std::string side : {"left", "right"}) {
    std::string parent = "chest";
    for (std::size_t k = 0; k < names.size(); ++k) {
      const std::string child = side + "_part" + std::to_string(k);
      const std::string at = k == 0 ? (side == "left" ? "0 0.4 0.3" : "0 -0.4 0.3") : "0 0 -0.5";
      const char* const shape =
          k == 2 ? R"(<collision><origin xyz="0 0 -0.5"/><geometry><box size="0.1 0.1 0.1"/>)"
                   "</geometry></collision>"
                 : "";
      text += fmt::format(
          R"(<link name="{0}"><inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.01" )"
          R"(ixy="0" ixz="0" iyz="0"/></inertial>{1}</link><joint name="{2}_{3}" type="revolute">)"
          R"(<parent link="{4}"/><child link="{0}"/><origin xyz="{5}"/><axis xyz="0 1 0"/>)"
          R"(<limit lower="-1" upper="1" effort="9" velocity="6"/></joint>)",
          child, shape, side, names[k], parent, at);
      parent = child;
    }
  }
  return text;
}

TEST(Limbs, HandsAreNeverFeet) {
  for (const auto& names : {std::array<const char*, 3>{"shoulder", "elbow", "wrist"},
                            std::array<const char*, 3>{"x1", "x2", "x3"}}) {
    const Limbs limbs =
        find_limbs(model_of(edited(Biped().urdf(), "", "</robot>", long_arms(names) + "</robot>")));
    EXPECT_EQ(limbs.left.sole, "left_foot");
    EXPECT_EQ(limbs.right.sole, "right_foot");
  }
  const std::string torso =
      "<robot name=\"torso\"><link name=\"chest\"><inertial><mass value=\"5\"/><inertia "
      "ixx=\"0.1\" iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link>" +
      long_arms({"shoulder", "elbow", "wrist"}) + "</robot>";
  EXPECT_TRUE(contains(complaint([&] { find_limbs(model_of(torso)); }),
                       "the robot has no legs, because its lowest links, \"left_part2\""));
}

TEST(Limbs, SidesMayBeSingleLettersInOrAtTheEndOfNames) {
  const std::string urdf = with_word(with_word(Biped().urdf(), "_left", "_l"), "_right", "_r");
  const robots::RobotDescription::Mirror inside = find_limbs(model_of(urdf)).mirror;
  EXPECT_EQ(inside.namesake("leg_l_roll"), "leg_r_roll");
  std::string suffixed = urdf;
  for (const char* part : {"pitch", "roll", "knee", "ankle_pitch", "ankle_roll", "lift"})
    for (const char* side : {"l", "r"})
      for (const char* limb : {"leg", "arm"})
        suffixed = with_word(suffixed, fmt::format("\"{}_{}_{}\"", limb, side, part),
                             fmt::format("\"{}_{}_{}\"", limb, part, side));
  const robots::RobotDescription::Mirror at_end = find_limbs(model_of(suffixed)).mirror;
  EXPECT_EQ(at_end.namesake("leg_roll_l"), "leg_roll_r");
  EXPECT_EQ(at_end.namesake("leg_roll_r"), "leg_roll_l");
}

TEST(Limbs, RefusesOtherUnitsExchangedSidesAndCoupledLegs) {
  const std::string urdf = Biped().urdf();
  const auto complaint_of = [](const std::string& text) {
    return complaint([&] { find_limbs(model_of(text)); });
  };
  std::string millimetres;
  for (std::size_t at = 0; at < urdf.size();) {
    const std::size_t start = std::min(urdf.find("origin xyz=\"", at), urdf.find("size=\"", at));
    if (start == std::string::npos) {
      millimetres += urdf.substr(at);
      break;
    }
    const std::size_t from = urdf.find('"', start) + 1, to = urdf.find('"', from);
    millimetres += urdf.substr(at, from - at);
    std::istringstream numbers(urdf.substr(from, to - from));
    for (double x; numbers >> x;) millimetres += fmt::format("{} ", 1e3 * x);
    at = to;
  }
  EXPECT_TRUE(contains(complaint_of(millimetres), "write all lengths in m"));
  EXPECT_TRUE(contains(complaint_of(with_word(urdf, "size=\"0.2 0.1 ", "size=\"200 100 ")),
                       "scale=\"0.001 0.001 0.001\""));
  const std::string exchanged =
      with_word(with_word(with_word(urdf, "left", "?"), "right", "left"), "?", "right");
  EXPECT_TRUE(contains(complaint_of(exchanged), "left and right are exchanged"));
  EXPECT_TRUE(
      contains(complaint_of(edited(urdf, "joint name=\"leg_left_knee\"", "<axis",
                                   "<mimic joint=\"leg_left_pitch\" multiplier=\"2\"/><axis")),
               "joint \"leg_left_knee\" of a leg follows \"leg_left_pitch\" by <mimic>"));
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

// Knees of any range bend forward, in both legs and in every posture.
TEST(SurveyedRobot, KneesBendForward) {
  for (const char* lower : {"-2.4", "-0.6", "-0.05"}) {
    Biped biped;
    biped.knee_lower = lower;
    const robots::UrdfModel model = biped.model();
    const robots::RobotDescription robot = survey_robot(model).description;
    for (const robots::StandingPosture& posture : robot.postures)
      for (const std::string& sole : {robot.left_sole, robot.right_sole})
        EXPECT_GT(knee_ahead(model, find_leg(model, sole), posture.joints), 0.01)  // m
            << lower << posture.name << sole;
    EXPECT_TRUE(holds(subjects(check(model, robot), Finding::Level::good), "knees"));
  }
}

// Text of the findings on the subject that are not good.
std::string doubts(const std::string& subject, const robots::UrdfModel& model,
                   const robots::RobotDescription& robot, Finding::Level level) {
  std::string text;
  for (const Finding& f : check(model, robot))
    if (f.subject == subject && f.level == level) text += f.text + "\n";
  return text;
}

TEST(Plausibility, KneesThatBendTheWrongWay) {
  const auto wrong = Finding::Level::wrong;
  Biped loose;
  loose.knee_lower = "-0.6";
  robots::RobotDescription robot = survey_robot(loose.model()).description;
  EXPECT_EQ(doubts("knees", loose.model(), robot, wrong), "");
  robot.postures[0].joints["leg_left_knee"] = -0.3;
  EXPECT_TRUE(contains(doubts("knees", loose.model(), robot, wrong),
                       "in \"left_stance\" the knee \"leg_left_knee\" is"));
  Biped backwards;
  backwards.knee_lower = "-2.4";
  backwards.knee_upper = "0.1";
  robot.postures.clear();
  EXPECT_TRUE(contains(doubts("knees", backwards.model(), robot, wrong),
                       "\"leg_left_knee\" bends the shin backwards by at most 0.10 rad"));
  robots::RobotDescription heels = robot;
  for (robots::FootRectangle* foot : {&heels.left_foot, &heels.right_foot})
    foot->x = between(-0.13, 0.07);
  EXPECT_TRUE(contains(doubts("knees", backwards.model(), heels, wrong), "are exchanged"));
  EXPECT_TRUE(contains(doubts("knees", Biped().model(), heels, Finding::Level::note),
                       "the forward direction is doubtful"));
}

TEST(Plausibility, Units) {
  const robots::RobotDescription robot = survey_robot(Biped().model()).description;
  const auto wrong = [&](const Biped& biped) {
    return doubts("units", biped.model(), robot, Finding::Level::wrong);
  };
  EXPECT_EQ(wrong(Biped()), "");
  Biped grams;
  grams.mass_unit = 1e3;
  EXPECT_TRUE(contains(wrong(grams), "4.004e+04 kg is too heavy"));
  Biped tonnes;
  tonnes.mass_unit = 1e-3;
  EXPECT_TRUE(contains(wrong(tonnes), "is too light"));
  Biped leaden;
  leaden.foot_mass = 40.0;
  EXPECT_TRUE(contains(wrong(leaden), "\"left_foot\" has 40 kg"));
  Biped spread;
  spread.foot_inertia_size = 0.8;
  EXPECT_TRUE(contains(doubts("units", spread.model(), robot, Finding::Level::note),
                       "the radii of gyration of \"left_foot\" and \"right_foot\""));
  robots::RobotDescription giant = robot;
  Biped biped;
  for (robots::StandingPosture& p : giant.postures) p.com *= 1e3;
  EXPECT_TRUE(
      contains(doubts("units", biped.model(), giant, Finding::Level::wrong), "write lengths in m"));
}

TEST(Plausibility, CoupledAndFrozenJoints) {
  const std::string urdf = Biped().urdf();
  robots::RobotDescription robot = survey_robot(model_of(urdf)).description;
  robot.postures.clear();
  const auto coupled = model_of(
      edited(urdf, "joint name=\"finger_left\"", "<axis", "<mimic joint=\"arm_left_lift\"/><axis"));
  EXPECT_TRUE(contains(doubts("joints", coupled, robot, Finding::Level::note),
                       "\"finger_left\" follow moving joints by <mimic>"));
  EXPECT_FALSE(holds(find_limbs(model_of(edited(urdf, "joint name=\"arm_left_lift\"", "<axis",
                                                "<mimic joint=\"waist_yaw\"/><axis")))
                         .joints,
                     "arm_left_lift"));
  robots::RobotDescription driven = robot;
  driven.joints.emplace_back().name = "finger_left";
  EXPECT_TRUE(contains(doubts("masses", coupled, driven, Finding::Level::wrong),
                       "joint \"finger_left\" follows \"arm_left_lift\" by <mimic>"));

  const auto bent = [&](const char* joint) {
    return model_of(
        edited(urdf, fmt::format("joint name=\"{}\"", joint), "lower=\"-1.5", "lower=\"0.2"));
  };
  EXPECT_TRUE(contains(doubts("joints", bent("finger_left"), robot, Finding::Level::note),
                       "\"finger_left\" are frozen at zero, outside their limits"));
  std::erase_if(robot.joints, [](const auto& joint) { return joint.name == "arm_left_lift"; });
  EXPECT_TRUE(contains(doubts("joints", bent("arm_left_lift"), robot, Finding::Level::wrong),
                       "\"arm_left_lift\" is frozen at zero, 0.2 rad outside its limits"));
}

TEST(Plausibility, DifferentSides) {
  const std::string urdf = Biped().urdf();
  robots::RobotDescription robot = survey_robot(model_of(urdf)).description;
  robot.postures.clear();
  const auto notes = [&](const std::string& after, const std::string& from, const std::string& to) {
    return doubts("sides", model_of(edited(urdf, after, from, to)), robot, Finding::Level::note);
  };
  EXPECT_TRUE(holds(subjects(check(model_of(urdf), robot), Finding::Level::good), "sides"));
  EXPECT_TRUE(contains(notes("link name=\"shin_right\"", "mass value=\"2\"", "mass value=\"2.3\""),
                       "different masses on the left and right: \"shin_left\" has 2 kg"));
  EXPECT_TRUE(contains(notes("link name=\"arm_right\"", "xyz=\"0 0", "xyz=\"0.02 0"),
                       "the CoMs of \"arm_left\" and \"arm_right\" are 20 mm"));
  EXPECT_TRUE(contains(notes("joint name=\"leg_right_knee\"", "upper=\"2.4", "upper=\"2.0"),
                       "joint \"leg_left_knee\" has 0 to 2.4 rad"));
  EXPECT_TRUE(contains(notes("joint name=\"arm_right_lift\"", "effort=\"80", "effort=\"8"),
                       "joint \"arm_left_lift\" has 80 Nm"));
  EXPECT_TRUE(contains(notes("joint name=\"arm_right_lift\"", "axis xyz=\"1 0", "axis xyz=\"1 1"),
                       "are 0.79 rad apart"));
  EXPECT_TRUE(contains(notes("joint name=\"leg_right_knee\"", "0 0 -0.4", "0 0 -0.41"),
                       "the left thigh is 400.0 mm long and the right one 410.0 mm"));
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
