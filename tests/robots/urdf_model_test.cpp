#include "saltus/robots/model/urdf_model.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <numbers>

#include "tests/support/errors.hpp"

namespace saltus {
namespace {

using Vec3 = Vec<double, 3>;

constexpr const char* good_inertia =
    R"(<inertia ixx="0.02" iyy="0.02" izz="0.01" ixy="0" ixz="0" iyz="0"/>)";

// <link> with a mass at `com`; `more` is added inside.
std::string link(const std::string& name, const std::string& mass, const std::string& com,
                 const std::string& inertia = good_inertia, const std::string& more = "") {
  return "<link name=\"" + name + "\"><inertial><origin xyz=\"" + com + "\"/><mass value=\"" +
         mass + "\"/>" + inertia + "</inertial>" + more + "</link>\n";
}

std::string joint(const std::string& name, const std::string& type, const std::string& parent,
                  const std::string& child, const std::string& xyz,
                  const std::string& rpy = "0 0 0") {
  return "<joint name=\"" + name + "\" type=\"" + type + "\"><origin xyz=\"" + xyz + "\" rpy=\"" +
         rpy + "\"/><parent link=\"" + parent + "\"/><child link=\"" + child +
         "\"/><axis xyz=\"0 1 0\"/><limit lower=\"-1\" upper=\"2\" effort=\"30\" velocity=\"1\"/>"
         "</joint>\n";
}

constexpr const char* foot_box =
    R"(<collision><origin xyz="0.03 -0.005 0.014"/><geometry><box size="0.16 0.07 0.002"/>)"
    R"(</geometry></collision>)";

// A body of 3 kg on one leg of 1 kg, whose knee turns about y; the foot link points down and the
// sole frame, a massless link, is turned back up.
std::string one_leg(const std::string& inside_foot = foot_box,
                    const std::string& leg_inertia = good_inertia, const std::string& mass = "3") {
  return "<?xml version=\"1.0\"?>\n<robot name=\"one leg\">\n" + link("body", mass, "0 0 0.2") +
         link("leg", "1", "0 0 -0.25", leg_inertia) + "<link name=\"foot\">" + inside_foot +
         "</link>\n<link name=\"sole\"/>\n" + joint("knee", "revolute", "body", "leg", "0 0 0") +
         joint("ankle", "fixed", "leg", "foot", "0 0 -0.5", "3.141592653589793 0 0") +
         joint("sole_joint", "fixed", "foot", "sole", "0 0 0.004", "-3.141592653589793 0 0") +
         "</robot>\n";
}

std::string complaint(const std::string& text) {
  return error_of<InputError>([&] { robots::UrdfModel::parse(text, "robot.urdf"); }, "");
}

template <class Act>
std::string input_error(const Act& act) {
  return error_of<InputError>(act, "");
}

void expect_has(const std::string& text, const std::string& part) {
  EXPECT_NE(text.find(part), std::string::npos) << "\"" << part << "\" is not in: " << text;
}

TEST(UrdfModel, KeepsVisualShapes) {
  const auto visual = [](const std::string& shape, const std::string& more = "") {
    return "<visual><origin xyz=\"0 0 0.1\"/><geometry>" + shape + "</geometry>" + more +
           "</visual>";
  };
  const std::string seen =
      foot_box + visual(R"(<mesh filename="package://robo/foot.stl" scale="0.001 0.001 -1"/>)") +
      visual(R"(<box size="1 2 3"/>)",
             R"(<material name="red"><color rgba="1 0 0.5 1"/></material>)") +
      visual(R"(<cylinder radius="0.5" length="4"/>)") + visual(R"(<sphere radius="0.5"/>)");
  const robots::UrdfModel model = robots::UrdfModel::parse(one_leg(seen), "robot.urdf");
  EXPECT_TRUE(model.links()[0].visuals.empty());
  const auto& visuals = model.links()[static_cast<std::size_t>(model.link_index("foot"))].visuals;
  ASSERT_EQ(visuals.size(), 4U);
  EXPECT_EQ(visuals[0].shape, robots::UrdfModel::LinkShape::Shape::mesh);
  EXPECT_EQ(visuals[0].mesh, "package://robo/foot.stl");
  EXPECT_EQ(visuals[0].size, Vec3(0.001, 0.001, -1.0));
  EXPECT_EQ(visuals[0].pose.translation(), Vec3(0.0, 0.0, 0.1));
  EXPECT_EQ(visuals[1].shape, robots::UrdfModel::LinkShape::Shape::box);
  EXPECT_EQ(visuals[1].size, Vec3(1.0, 2.0, 3.0));
  EXPECT_EQ(visuals[1].colour, Vec3(1.0, 0.0, 0.5));
  EXPECT_EQ(visuals[2].shape, robots::UrdfModel::LinkShape::Shape::cylinder);
  EXPECT_EQ(visuals[2].size, Vec3(1.0, 1.0, 4.0));
  EXPECT_EQ(visuals[3].shape, robots::UrdfModel::LinkShape::Shape::sphere);
  EXPECT_EQ(visuals[3].size, Vec3(1.0, 1.0, 1.0));
}

TEST(UrdfModel, SumsTheMass) {
  const robots::UrdfModel model = robots::UrdfModel::parse(one_leg(), "robot.urdf");
  EXPECT_EQ(model.name(), "one leg");
  EXPECT_EQ(model.total_mass(), 4.0);
  ASSERT_EQ(model.links().size(), 4u);
  EXPECT_EQ(model.links()[0].name, "body");
  EXPECT_EQ(model.links()[model.link_index("foot")].mass, 0.0);  // a massless frame
  EXPECT_EQ(model.moving_joint_names(), std::vector<std::string>{"knee"});
  const robots::UrdfModel::Joint& knee = model.links()[model.link_index("leg")].joint;
  EXPECT_EQ(knee.position, between(-1.0, 2.0));
  EXPECT_EQ(knee.effort, 30.0);
}

// Children of a link are sorted by the names of their joints, whatever their order in the file.
TEST(UrdfModel, OrdersLinksByTheTree) {
  const auto joint = [](const std::string& name, const std::string& from, const std::string& to) {
    return fmt::format(
        "<joint name=\"{}\" type=\"continuous\"><parent link=\"{}\"/><child "
        "link=\"{}\"/></joint>\n",
        name, from, to);
  };
  std::string text = "<robot name=\"tree\">\n";
  for (const char* name : {"foot", "arm", "leg", "root"}) text += link(name, "1", "0 0 0");
  text += joint("c", "root", "arm") + joint("z", "leg", "foot") + joint("b", "root", "leg");
  const robots::UrdfModel model = robots::UrdfModel::parse(text + "</robot>\n", "robot.urdf");
  EXPECT_EQ(model.link_names(), (std::vector<std::string>{"root", "leg", "foot", "arm"}));
  EXPECT_EQ(model.moving_joint_names(), (std::vector<std::string>{"b", "z", "c"}));
}

TEST(UrdfModel, FollowsTheJointsToTheCentreOfMass) {
  const robots::UrdfModel model = robots::UrdfModel::parse(one_leg(), "robot.urdf");
  // Straight: body at 0.2, leg at -0.25 of the hip; the sole 0.504 below it.
  EXPECT_LT((model.centre_of_mass("body", {}) - Vec3(0, 0, (3 * 0.2 - 0.25) / 4)).norm(), 1e-15);
  EXPECT_LT((model.centre_of_mass("sole", {}) - Vec3(0, 0, 0.0875 + 0.504)).norm(), 1e-15);
  // Knee at 90 degrees about y: the leg points along -x of the body.
  const robots::Posture bent{{"knee", std::numbers::pi / 2}};
  EXPECT_LT((model.centre_of_mass("body", bent) - Vec3(-0.25 / 4, 0, 0.15)).norm(), 1e-15);
  const Eigen::Isometry3d sole = model.link_pose("sole", "body", bent);
  EXPECT_LT((sole.translation() - Vec3(-0.504, 0, 0)).norm(), 1e-15);
  EXPECT_LT((sole.linear().col(2) - Vec3(1, 0, 0)).norm(), 1e-15);
  // Seen from the sole, which stays on the ground, the body lies down.
  EXPECT_LT((model.centre_of_mass("sole", bent) - Vec3(-0.15, 0, 0.504 - 0.0625)).norm(), 1e-15);
}

TEST(UrdfModel, RotatesTheInertiaToLinkAxes) {
  std::string text = one_leg();
  const std::string before = "<origin xyz=\"0 0 0.2\"/>";
  text.replace(text.find(before), before.size(),
               "<origin xyz=\"0 0 0.2\" rpy=\"0 1.5707963267948966 0\"/>");
  const robots::UrdfModel model = robots::UrdfModel::parse(text, "robot.urdf");
  EXPECT_LT((model.links()[0].inertia.diagonal() - Vec3(0.01, 0.02, 0.02)).norm(), 1e-15);
}

TEST(UrdfModel, TakesTheFootFromTheCollisionBox) {
  const robots::UrdfModel::Foot foot =
      robots::UrdfModel::parse(one_leg(), "robot.urdf").foot("sole");
  // The box is given in the foot link, which points down: y changes sign in the sole.
  EXPECT_NEAR(foot.rectangle.x.lower, -0.05, 1e-15);
  EXPECT_NEAR(foot.rectangle.x.upper, 0.11, 1e-15);
  EXPECT_NEAR(foot.rectangle.y.lower, -0.03, 1e-15);
  EXPECT_NEAR(foot.rectangle.y.upper, 0.04, 1e-15);
  EXPECT_NEAR(foot.contact_plane_offset, -0.011, 1e-15);
}

TEST(UrdfModel, JoinsHeelAndToeAndLeavesOutHigherBoxes) {
  const auto box = [](const char* xyz, const char* size) {
    return std::string("<collision><origin xyz=\"") + xyz + "\"/><geometry><box size=\"" + size +
           "\"/></geometry></collision>";
  };
  const robots::UrdfModel::Foot foot =
      robots::UrdfModel::parse(
          one_leg(box("0.1 0 0.01", "0.04 0.08 0.02") + box("-0.03 0 0.01", "0.04 0.06 0.02") +
                  box("0 0 0", "1 1 0.01")),
          "robot.urdf")
          .foot("sole");
  EXPECT_NEAR(foot.rectangle.x.lower, -0.05, 1e-15);
  EXPECT_NEAR(foot.rectangle.x.upper, 0.12, 1e-15);
  EXPECT_NEAR(foot.rectangle.y.upper, 0.04, 1e-15);
  EXPECT_NEAR(foot.contact_plane_offset, -0.016, 1e-15);
}

// A bevelled toe touches the ground with its edge, and does not change the rectangle. A lower one
// is rejected.
TEST(UrdfModel, LeavesOutRotatedBoxesThatAreNotLower) {
  const auto foot_with_toe = [](const char* xyz) {
    std::string toe = foot_box;
    toe.replace(toe.find("xyz=\""), toe.find("\"/>") - toe.find("xyz=\""),
                std::string("xyz=\"") + xyz + "\" rpy=\"0 0.5 0");
    return robots::UrdfModel::parse(one_leg(foot_box + toe), "robot.urdf").foot("sole");
  };
  const robots::UrdfModel::Foot plain =
      robots::UrdfModel::parse(one_leg(), "robot.urdf").foot("sole");
  const robots::UrdfModel::Foot foot = foot_with_toe("0.1 0 -0.1");
  EXPECT_EQ(foot.contact_plane_offset, plain.contact_plane_offset);
  EXPECT_EQ(foot.rectangle.x.upper, plain.rectangle.x.upper);
  expect_has(input_error([&] { foot_with_toe("0.1 0 0.1"); }), "rotated relative to the frame");
}

TEST(UrdfModel, KeepsTheLeaderOfACoupledJoint) {
  std::string text = one_leg();
  const std::size_t at = text.find("<axis", text.find("\"knee\""));
  ASSERT_NE(at, std::string::npos);
  text.insert(at, "<mimic joint=\"hip\"/>");
  const robots::UrdfModel model = robots::UrdfModel::parse(text, "robot.urdf");
  for (const robots::UrdfModel::Link& link : model.links())
    EXPECT_EQ(link.joint.leader, link.joint.name == "knee" ? "hip" : "") << link.joint.name;
}

TEST(UrdfModel, RejectsAFootWithoutRectangle) {
  const auto foot_complaint = [](const std::string& inside) {
    return input_error(
        [&] { robots::UrdfModel::parse(one_leg(inside), "robot.urdf").foot("sole"); });
  };
  expect_has(foot_complaint(""), "has no collision box");
  expect_has(foot_complaint("<collision><geometry><sphere radius=\"0.1\"/></geometry></collision>"),
             "has no collision box");
  std::string turned = foot_box;
  turned.replace(turned.find("0.014\""), 6, "0.014\" rpy=\"0 0 0.2\"");
  expect_has(foot_complaint(turned), "rotated relative to the frame of \"sole\"");
  std::string flat = foot_box;
  flat.replace(flat.find("0.16 0.07"), 9, "0.16 0");
  expect_has(foot_complaint(flat), "has no area");
}

TEST(UrdfModel, SuggestsTheNearestName) {
  const robots::UrdfModel model = robots::UrdfModel::parse(one_leg(), "robot.urdf");
  expect_has(input_error([&] { model.foot("soel"); }),
             "robot.urdf: there is no link \"soel\"; did you mean \"sole\"?");
  expect_has(input_error([&] { model.foot("l_gripper_camera"); }), "there is no link");
  expect_has(input_error([&] {
               model.centre_of_mass("sole", {{"kne", 0.1}});
             }),
             "there is no movable joint \"kne\"; did you mean \"knee\"?");
  expect_has(input_error([&] { model.centre_of_mass("sole", {{"ankle", 0.1}}); }), "movable");
  expect_has(input_error([&] {
               model.centre_of_mass("sole", {{"knee", std::nan("")}});
             }),
             "position of joint \"knee\" is nan");
}

TEST(UrdfModel, RejectsImpossibleBodies) {
  const auto inertia = [](const char* xx, const char* yy, const char* zz) {
    return std::string("<inertia ixx=\"") + xx + "\" iyy=\"" + yy + "\" izz=\"" + zz +
           "\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/>";
  };
  expect_has(complaint(one_leg(foot_box, inertia("0.1", "0.1", "0.3"))),
             "link \"leg\" has a physically impossible inertia");
  expect_has(complaint(one_leg(foot_box, inertia("0.1", "0.1", "-0.1"))), "link \"leg\" has an");
  expect_has(complaint(one_leg(foot_box, inertia("0", "0", "0"))), "is not positive");
  expect_has(complaint(one_leg(foot_box, inertia("0", "0.1", "0.1"))), "is not positive");
  EXPECT_EQ(complaint(one_leg(foot_box, inertia("0.1", "0.2", "0.3"))), "");  // flat, but valid
  expect_has(complaint(one_leg(foot_box, good_inertia, "-3")), "\"body\" has the negative mass -3");
  // urdfdom does not read non-finite numbers and would continue without them.
  expect_has(complaint(one_leg(foot_box, inertia("nan", "0.1", "0.1"))), "element for Link [leg]");
  expect_has(complaint(one_leg(foot_box, good_inertia, "nan")), "mass [nan] is not a float");
  expect_has(complaint(one_leg(foot_box, good_inertia, "inf")), "element for Link [body]");
  expect_has(complaint(one_leg("<inertial><mass value=\"1\"/></inertial>")), "for Link [foot]");
  expect_has(complaint(one_leg("<collision><geometry><box/></geometry></collision>")),
             "collision element for Link [foot]");
  EXPECT_EQ(complaint(one_leg("<visual><geometry><mesh/></geometry></visual>")), "");
  expect_has(complaint("<robot name=\"ghost\"><link name=\"a\"/></robot>"), "has no mass");
}

TEST(UrdfModel, MergesMasslessLinksIntoTheirBody) {
  const auto robot = [](const char* joint_type) {
    return fmt::format(
        "<robot name=\"r\"><link name=\"a\"><inertial><mass value=\"2\"/><inertia ixx=\"0.1\" "
        "iyy=\"0.1\" izz=\"0.1\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial></link><link "
        "name=\"sensor\"><inertial><mass value=\"0.1\"/><inertia ixx=\"0\" iyy=\"0\" izz=\"0\" "
        "ixy=\"0\" ixz=\"1e-20\" iyz=\"0\"/></inertial></link><joint name=\"j\" "
        "type=\"{}\"><parent "
        "link=\"a\"/><child link=\"sensor\"/><axis xyz=\"0 0 1\"/></joint></robot>",
        joint_type);
  };
  EXPECT_EQ(complaint(robot("fixed")), "");
  expect_has(complaint(robot("continuous")),
             "link \"sensor\", together with the links fixed to it, has an");
}

TEST(UrdfModel, RejectsCyclesAndImplausibleMasses) {
  const auto link = [](const char* name) { return fmt::format("<link name=\"{}\"/>", name); };
  const auto joint = [](const char* parent, const char* child) {
    return fmt::format(
        "<joint name=\"{0}{1}\" type=\"fixed\"><parent link=\"{0}\"/><child link=\"{1}\"/></joint>",
        parent, child);
  };
  const std::string links = "<robot name=\"r\">" + link("a") + link("b") + link("c");
  expect_has(complaint(links + joint("a", "b") + joint("b", "c") + joint("c", "b") + "</robot>"),
             "form a cycle through link \"b\"");
  expect_has(complaint(links + joint("b", "c") + joint("c", "b") + "</robot>"), "form a cycle");
  expect_has(complaint(one_leg(foot_box, good_inertia, "1e100")), "implausible mass");
}

TEST(UrdfModel, RejectsOtherFilesWithoutPrinting) {
  ::testing::internal::CaptureStdout();
  ::testing::internal::CaptureStderr();
  expect_has(complaint(""), "robot.urdf: the file is empty");
  expect_has(complaint("  \n"), "the file is empty");
  expect_has(complaint("mass: 3\n"), "has no <robot> element");
  expect_has(complaint("<sdf version=\"1.6\"><model name=\"a\"/></sdf>"), "has no <robot>");
  expect_has(complaint("<robot"), "robot.urdf: ");
  expect_has(complaint("<robot name=\"empty\"/>"), "robot.urdf: ");
  expect_has(complaint("<robot name=\"two\"><link name=\"a\"/><link name=\"b\"/></robot>"), "root");
  const std::string whole = one_leg();
  const std::size_t end = whole.rfind("</robot>") + std::string("</robot>").size();
  for (std::size_t length = 0; length < end; length += 7)
    expect_has(complaint(whole.substr(0, length)), "robot.urdf: ");
  EXPECT_EQ(complaint(whole), "");
  EXPECT_EQ(::testing::internal::GetCapturedStdout(), "");
  EXPECT_EQ(::testing::internal::GetCapturedStderr(), "");
}

TEST(UrdfModel, NamesFilesInErrors) {
  const std::filesystem::path folder = ::testing::TempDir();
  const std::filesystem::path file = folder / "saltus_one_leg.urdf";
  std::ofstream(file) << one_leg();
  EXPECT_EQ(robots::UrdfModel::read(file).total_mass(), 4.0);
  EXPECT_EQ(robots::UrdfModel::read(file).source(), file.string());
  std::ofstream(file, std::ios::trunc).close();
  expect_has(input_error([&] { robots::UrdfModel::read(file); }),
             file.string() + ": the file is empty");
  std::filesystem::remove(file);
  expect_has(input_error([&] { robots::UrdfModel::read(file); }), "there is no such file");
  expect_has(input_error([&] { robots::UrdfModel::read(folder); }), "this is not a file");
}

}  // namespace
}  // namespace saltus
