#include "saltus/robots/model/robot_description.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>

#include "saltus/robots/icub/icub.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "tests/support/errors.hpp"

namespace saltus {
namespace {

const std::string sample = R"(
name: Robo
source: made up
mass: 30
soles: {left: ls, right: rs}
contact_plane_offset: -0.01
left_foot: {x: [-0.05, 0.1], y: [-0.03, 0.04]}
right_foot: {x: [-0.05, 0.1], y: [-0.04, 0.03]}
postures:
  stand:
    stance: both
    com: [0, -0.07, 0.5]
    other_foot: [0, -0.14, 0]
    joints: {knee: -0.5}
  crouch:
    stance: left
    com: [0, 0, 0.4]
    other_foot: [0, -0.14, 0.01]
    joints: {}
)";

std::string changed(const std::string& from, const std::string& to) {
  std::string text = sample;
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

std::string complaint(const std::string& text) {
  return error_of<InputError>([&] { robots::parse_robot_description(text, "robot.yaml"); }, "");
}

void expect_has(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in: " << text;
}

TEST(RobotDescription, ReadsEveryKey) {
  const robots::RobotDescription robot = robots::parse_robot_description(sample, "robot.yaml");
  EXPECT_EQ(robot.name, "Robo");
  EXPECT_EQ(robot.source, "robot.yaml (made up)");
  EXPECT_EQ(robot.mass, 30.0);
  EXPECT_EQ(robot.left_sole, "ls");
  EXPECT_EQ(robot.contact_plane_offset, -0.01);
  EXPECT_EQ(robot.right_foot, robot.left_foot.mirrored());
  EXPECT_EQ(robot.default_posture().name, "stand");
  EXPECT_EQ(robot.posture("stand").joints.at("knee"), -0.5);
  EXPECT_EQ(robot.posture("crouch").stance, robots::Stance::left);
  EXPECT_EQ(robot.posture("crouch").com.z(), 0.4);
  expect_error<InputError>([&] { robot.posture("stnad"); }, {"did you mean \"stand\"?"});
}

TEST(RobotDescription, ReadsDrivesAndSensors) {
  const auto with = [](const std::string& joint, const std::string& more = "") {
    return robots::parse_robot_description(
        sample + ("base: pelvis\njoints: {knee: {" + joint + "}}\n" + more), "robot.yaml");
  };
  const robots::RobotDescription robot = with(
      "rotor_inertia: 0.1, dry_friction: 2, breakaway: 1.5, viscous_friction: 0.5, "
      "stall_torque: 30, no_load_speed: 8, stiffness: 1e4, backlash: 0.001",
      "foot_sensor_range: [1, 2, 3, 4, 5, 6]\n");
  const robots::JointDrive& drive = robot.joints[0].drive;
  EXPECT_EQ(drive.rotor_inertia, 0.1);
  EXPECT_EQ(drive.dry_friction, 2.0);
  EXPECT_EQ(drive.breakaway, 1.5);
  EXPECT_EQ(drive.viscous_friction, 0.5);
  EXPECT_EQ(drive.stall_torque, 30.0);
  EXPECT_EQ(drive.no_load_speed, 8.0);
  EXPECT_EQ(drive.stiffness, 1e4);
  EXPECT_EQ(drive.backlash, 1e-3);
  EXPECT_EQ((*robot.foot_sensor_range)[5], 6.0);
  EXPECT_TRUE(with("").joints[0].drive.is_ideal());
  EXPECT_EQ(with("").joints[0].drive.stiffness, infinity);
  EXPECT_FALSE(with("").foot_sensor_range);
  expect_error<InputError>([&] { with("rotor_inertia: -1"); },
                           {"rotor_inertia must be at least 0"});
  expect_error<InputError>([&] { with("breakaway: 0.5"); }, {"breakaway must be at least 1"});
  expect_error<InputError>([&] { with("stall_torque: 0"); }, {"stall_torque must be positive"});
  expect_error<InputError>([&] { with("no_load_speed: 0"); }, {"no_load_speed must be positive"});
  expect_error<InputError>([&] { with("rotor_inertia: 0.1, stiffness: 0"); },
                           {"stiffness must be positive"});
  expect_error<InputError>([&] { with("rotor_inertia: 0.1, backlash: 0.001"); },
                           {"backlash needs a spring at its ends; add stiffness"});
  expect_error<InputError>([&] { with("stiffness: 1e4"); },
                           {"stiffness needs a rotor that turns the spring; add rotor_inertia"});
  expect_error<InputError>([&] { with("", "foot_sensor_range: [1, 2, 3, 4, 5, 0]\n"); },
                           {"foot_sensor_range must have six positive numbers"});
}

TEST(RobotDescription, RejectsInvalidFiles) {
  expect_has(complaint(""), "robot.yaml: the file is empty");
  expect_has(complaint("name: [1, 2"), "not valid YAML");
  expect_has(complaint("- 1\n- 2\n"), "must be a set of keys");
  expect_has(complaint(changed("mass:", "mas:")), "mas is not a known key; did you mean \"mass\"?");
  expect_has(complaint(changed("stance: both", "stanec: both")),
             "postures.stand.stanec is not a known key; did you mean \"stance\"?");
  expect_has(complaint(changed("mass: 30\n", "")), "mass is missing");
  expect_has(complaint(changed("mass: 30", "mass: heavy")), "mass must be a number, not \"heavy\"");
  expect_has(complaint(changed("mass: 30", "mass: [30]")), "mass must be a number");
  expect_has(complaint(changed("mass: 30", "mass: .nan")), "mass must be finite, not nan");
  expect_has(complaint(changed("mass: 30", "mass: 0")), "mass must be positive, not 0 kg");
  expect_has(complaint(changed("mass: 30", "mass: 30\nmass: 31")),
             "key 'mass' was already given at robot.yaml:4");
  expect_has(complaint(changed("x: [-0.05, 0.1]", "x: [0.1, -0.05]")), "left_foot.x is empty");
  expect_has(complaint(changed("x: [-0.05, 0.1]", "x: [0.1]")), "must be a list of 2 numbers");
  expect_has(complaint(changed("stance: both", "stance: one")),
             "stance must be left, right or both");
  expect_has(complaint(changed("0.5]", "-0.5]")), "postures.stand.com must be above the ground");
  expect_has(complaint(changed("{knee: -0.5}", "{knee: bent}")), "postures.stand.joints.knee must");
  expect_has(complaint(changed("soles: {left: ls, right: rs}", "soles: ls")),
             "soles must be a set");
  EXPECT_THROW(robots::read_robot_description("/nowhere/robot.yaml"), InputError);
}

TEST(RobotDescription, DataMayComeFromTheUrdf) {
  const std::string mass = "mass: 30\n", place = "    com: [0, -0.07, 0.5]\n";
  std::string text = changed(mass, "");
  text.replace(text.find(place), place.size(), "");
  const robots::RobotDescription robot = robots::parse_robot_description(
      text, "robot.yaml", robots::RobotDescription::Figures::from_urdf);
  EXPECT_TRUE(std::isnan(robot.mass));
  EXPECT_TRUE(std::isnan(robot.posture("stand").com.z()));
  EXPECT_EQ(robot.posture("crouch").com.z(), 0.4);
  expect_has(complaint(text), "robot.yaml: mass is missing; add it, or name the URDF");
}

const std::string mirror = "mirror: {left: l_, right: r_, reversed: [waist]}\npostures:";
const std::string joints = "{waist: 0.1, chest: 0.2, l_knee: -0.3, r_ankle: 0.4}";

TEST(RobotDescription, MirrorImageSwapsSidesAndReversesNamedJoints) {
  std::string text = changed("postures:", mirror);
  text.replace(text.find("{}"), 2, joints);
  const robots::RobotDescription robot =
      robots::parse_robot_description(text + "  other: {mirror_of: crouch}\n", "robot.yaml");
  const robots::StandingPosture& image = robot.posture("other");
  EXPECT_EQ(&image, &robot.posture_on(robots::Side::right));
  EXPECT_EQ(image.stance, robots::Stance::right);
  EXPECT_EQ(image.other_foot, (Vec<double, 3>(0.0, 0.14, 0.01)));
  EXPECT_EQ(image.joints,
            (robots::Posture{{"waist", -0.1}, {"chest", 0.2}, {"r_knee", -0.3}, {"l_ankle", 0.4}}));
  const robots::StandingPosture back = (*robot.mirror)(image);
  EXPECT_EQ(back.stance, robots::Stance::left);
  EXPECT_EQ(back.com, robot.posture("crouch").com);
  EXPECT_EQ(back.joints, robot.posture("crouch").joints);
}

TEST(RobotDescription, SidesAreMarkedAtTheBeginningTheEndOrInside) {
  const auto namesake = [](const char* left, const char* right, const char* joint) {
    return robots::RobotDescription::Mirror{left, right, {}}.namesake(joint);
  };
  EXPECT_EQ(namesake("l_", "r_", "r_hip_l"), "l_hip_l");
  EXPECT_EQ(namesake("_l", "_r", "hip_roll_l"), "hip_roll_r");
  EXPECT_EQ(namesake("_l", "_r", "hip_roll"), "hip_roll");
  EXPECT_EQ(namesake("l", "r", "torso_roll"), "torso_roll");
  EXPECT_EQ(namesake("_l_", "_r_", "hip_r_roll"), "hip_l_roll");
}

TEST(RobotDescription, RejectsMirrorImagesWithoutRuleOrOriginal) {
  const std::string image = "  other: {mirror_of: crouch}\n";
  expect_has(complaint(sample + image), "postures.other.mirror_of needs the key mirror");
  const std::string ruled = changed("postures:", mirror);
  expect_has(complaint(ruled + "  other: {mirror_of: stand}\n"), "\"stand\" is on both feet");
  expect_has(complaint(ruled + "  other: {mirror_of: sit}\n"),
             "must name a posture that precedes it");
  const robots::RobotDescription robot = robots::parse_robot_description(sample, "robot.yaml");
  EXPECT_EQ(&robot.posture_on(robots::Side::left), &robot.posture("crouch"));
  expect_error<InputError>([&] { robot.posture_on(robots::Side::right); },
                           {"Robo has no posture on the right foot alone"});
}

TEST(RobotDescription, ReadsFiles) {
  const std::filesystem::path file =
      std::filesystem::path(::testing::TempDir()) / "saltus_rob.yaml";
  std::ofstream(file) << sample;
  EXPECT_EQ(robots::read_robot_description(file).source, file.string() + " (made up)");
  std::filesystem::remove(file);
}

TEST(Icub, HasTheOfficialData) {
  const robots::RobotDescription robot = icub();
  EXPECT_NEAR(robot.mass, 33.0617, 1e-4);
  EXPECT_EQ(robot.left_foot,
            (robots::FootRectangle{between(-0.0535, 0.1065), between(-0.031, 0.041)}));
  EXPECT_EQ(robot.right_foot, robot.left_foot.mirrored());
  EXPECT_EQ(robot.contact_plane_offset, -0.0105);
  expect_has(robot.source, "robots/icub/icub.yaml");
  EXPECT_EQ(robot.default_posture().name, "left_stance");
  EXPECT_NEAR(robot.posture("zero").com.z(), 0.553, 5e-4);
  EXPECT_NEAR(robot.posture("two_feet").com.z(), 0.534, 5e-4);
  EXPECT_NEAR(pendulum_frequency(robot.posture("two_feet").com.z()), 4.287, 3e-3);
  EXPECT_NEAR(robot.posture("two_feet").other_foot.y(), -0.14, 5e-4);
  // Balancing on the left foot: the CoM within 3 mm of the sole's origin.
  EXPECT_LT(robot.posture("left_stance").com.head<2>().norm(), 0.003);
}

// The model's right sole lies 0.106 mm behind the left one (posture zero), and its masses deviate
// from mirror symmetry by about as much. Seen from the other sole, the error is doubled.
constexpr double asymmetry = 2.2e-4;  // m

TEST(Icub, ParameterFileAgreesWithTheUrdf) {
  const char* urdf = std::getenv("SALTUS_ICUB_URDF");
  if (!urdf || !*urdf)
    GTEST_SKIP() << "SALTUS_ICUB_URDF does not name the URDF of iCubGazeboV2_5, which is not part "
                    "of this repository";
  const robots::RobotDescription file = icub();
  const robots::RobotDescription computed = icub(std::filesystem::path(urdf));
  expect_has(computed.source, urdf);
  // The file has ten decimals; the URDF's masses add up with rounding.
  constexpr double printed = 1e-9;
  EXPECT_NEAR(file.mass, computed.mass, printed);
  EXPECT_NEAR(file.contact_plane_offset, computed.contact_plane_offset, printed);
  const auto same = [&](const robots::FootRectangle& a, const robots::FootRectangle& b) {
    EXPECT_NEAR(a.x.lower, b.x.lower, printed);
    EXPECT_NEAR(a.x.upper, b.x.upper, printed);
    EXPECT_NEAR(a.y.lower, b.y.lower, printed);
    EXPECT_NEAR(a.y.upper, b.y.upper, printed);
  };
  same(file.left_foot, computed.left_foot);
  same(file.right_foot, computed.right_foot);
  ASSERT_EQ(file.postures.size(), computed.postures.size());
  for (std::size_t i = 0; i < file.postures.size(); ++i) {
    // The file has the exact image of the left stance.
    const double within = file.postures[i].stance == robots::Stance::right ? asymmetry : printed;
    EXPECT_LT((file.postures[i].com - computed.postures[i].com).norm(), within)
        << file.postures[i].name;
    EXPECT_LT((file.postures[i].other_foot - computed.postures[i].other_foot).norm(), within)
        << file.postures[i].name;
  }
  // The model's 213 links, 174 of them frames without mass.
  const robots::UrdfModel model = robots::UrdfModel::read(urdf);
  EXPECT_EQ(model.links().size(), 213u);
  EXPECT_EQ(std::count_if(model.links().begin(), model.links().end(),
                          [](const robots::UrdfModel::Link& link) { return link.mass == 0.0; }),
            174);
  EXPECT_EQ(model.moving_joint_names().size(), 32u);
}

// One joint at a time, so that a wrong sign cannot hide.
TEST(Icub, MirroredJointsGiveTheMirroredBody) {
  const char* urdf = std::getenv("SALTUS_ICUB_URDF");
  if (!urdf || !*urdf) GTEST_SKIP() << "SALTUS_ICUB_URDF does not name the URDF";
  const robots::RobotDescription robot = icub();
  const robots::UrdfModel model = robots::UrdfModel::read(urdf);
  for (const robots::RobotDescription::Joint& joint : robot.joints) {
    robots::StandingPosture left = robot.posture_on(robots::Side::left);
    left.joints[joint.name] += 0.3;  // rad
    const robots::StandingPosture right = (*robot.mirror)(left);
    Vec<double, 3> a = model.centre_of_mass(robot.left_sole, left.joints);
    Vec<double, 3> b = model.centre_of_mass(robot.right_sole, right.joints);
    b.y() *= -1.0;
    EXPECT_LT((a - b).norm(), asymmetry) << joint.name;
    a = model.link_pose(robot.right_sole, robot.left_sole, left.joints).translation();
    b = model.link_pose(robot.left_sole, robot.right_sole, right.joints).translation();
    b.y() *= -1.0;
    EXPECT_LT((a - b).norm(), asymmetry) << joint.name;
  }
}

TEST(Icub, ReportsMissingUrdfData) {
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "saltus_no.urdf";
  std::ofstream(file) << R"(<robot name="other"><link name="left_sole"><inertial><mass value="1"/>
    <inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial></link></robot>)";
  expect_error<InputError>([&] { icub(file); }, {file.string() + ": there is no link \"l_sole\""});
  std::filesystem::remove(file);
  EXPECT_THROW(icub(file), InputError);
}

}  // namespace
}  // namespace saltus
