#include "saltus/robots/mujoco/mjcf.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/whole_body/ground.hpp"

namespace saltus::robots::mujoco_engine {
namespace {

// Contacts are springs and dampers at the acceleration level: time constant (s) and damping ratio
// of the penetration. Friction is stiffer by a factor, so that a loaded foot does not creep.
constexpr double contact_time = 0.005, contact_damping = 1.0, friction_stiffness = 10.0;

// Second limit of a joint that is limited on one side only, rad.
constexpr double no_limit = 1e4;

// ---- MJCF --------------------------------------------------------------------------------------

std::string numbers(const char* attribute, const Eigen::Ref<const VectorXd>& values) {
  std::string text = fmt::format(" {}=\"", attribute);
  for (const double v : values) text += fmt::format("{:.17g} ", v);
  text.back() = '"';
  return text;
}

std::string pose_xml(const Eigen::Isometry3d& pose) {
  const Eigen::Quaterniond q(pose.linear());
  return numbers("pos", pose.translation()) +
         numbers("quat", Vec<double, 4>(q.w(), q.x(), q.y(), q.z()));
}

bool is_foot(const FloatingRobot& robot, int body) {
  return body == robot.left_sole.body || body == robot.right_sole.body;
}

// Collision bits: 1 for the ground, 2 for limbs among each other.
std::string capsule_xml(const Capsule& capsule, bool is_of_foot) {
  constexpr double shortest = 1e-4;  // m; MuJoCo requires a positive length
  Vec<double, 6> ends;
  ends << capsule.from, capsule.to;
  if (capsule.length() < shortest) ends[5] += shortest;
  return fmt::format(
      "<geom type=\"capsule\" contype=\"{}\" conaffinity=\"2\" size=\"{:.17g}\"{}/>\n",
      is_of_foot ? 2 : 3, capsule.radius, numbers("fromto", ends));
}

// Text of an attribute in XML.
std::string escaped(const std::string& name) {
  std::string text;
  for (const char c : name) {
    if (c == '&')
      text += "&amp;";
    else if (c == '<')
      text += "&lt;";
    else if (c == '"')
      text += "&quot;";
    else
      text += c;
  }
  return text;
}

// Excludes pairs of bodies that may touch. MuJoCo itself excludes a body and its parent.
std::string exclusions_xml(const FloatingRobot& robot, bool names) {
  std::string text = "<contact>\n";
  const int bodies = static_cast<int>(robot.bodies.size());
  const auto name = [&](int i) {
    return names ? escaped(robot.bodies[static_cast<std::size_t>(i)].name) : std::to_string(i);
  };
  for (int a = 0; a < bodies; ++a)
    for (int b = a + 1; b < bodies; ++b)
      if (robot.bodies[static_cast<std::size_t>(b)].parent != a &&
          std::find(robot.apart.begin(), robot.apart.end(), std::pair(a, b)) == robot.apart.end())
        text += fmt::format("<exclude body1=\"{}\" body2=\"{}\"/>\n", name(a), name(b));
  return text + "</contact>\n";
}

// Writes the tree of bodies. Without `names`, names are numbers, and drives have no friction.
class BodyWriter {
 public:
  BodyWriter(const FloatingRobot& robot, const Plant::Options& options, bool names)
      : robot_(robot), options_(options), names_(names) {}

  std::string body(int i) {
    const FloatingRobot::Body& b = robot_.bodies[static_cast<std::size_t>(i)];
    const Mat<double, 3, 3>& I = b.inertia;
    std::string text = fmt::format(
        "<body name=\"{}\"{}>\n", names_ ? escaped(b.name) : std::to_string(i), pose_xml(b.origin));
    if (b.parent < 0) {
      text += fmt::format("<freejoint name=\"{}\"/>\n", names_ ? "floating_base" : "0");
    } else {
      order_.push_back(i - 1);
      const bool limited = b.position.lower > -infinity || b.position.upper < infinity;
      text += fmt::format(
          "<joint name=\"{}\" type=\"hinge\"{} damping=\"{:.17g}\" armature=\"{:.17g}\" "
          "limited=\"{}\"",
          names_ ? escaped(b.joint) : std::to_string(i), numbers("axis", b.axis),
          options_.joint_friction + (names_ ? b.drive.viscous_friction : 0.0),
          b.drive.rotor_inertia, limited);
      if (names_ && b.drive.dry_friction > 0.0)
        text += fmt::format(" frictionloss=\"{:.17g}\"", b.drive.dry_friction);
      if (limited)
        text += numbers("range", Vec<double, 2>(std::max(b.position.lower, -no_limit),
                                                std::min(b.position.upper, no_limit)));
      text += "/>\n";
    }
    Vec<double, 6> inertia;
    inertia << I(0, 0), I(1, 1), I(2, 2), I(0, 1), I(0, 2), I(1, 2);
    text += fmt::format("<inertial mass=\"{:.17g}\"{}{}/>\n", b.mass, numbers("pos", b.com),
                        numbers("fullinertia", inertia));
    for (const UrdfModel::Box& box : b.boxes)
      text += fmt::format("<geom type=\"box\" contype=\"1\" conaffinity=\"0\"{}{}/>\n",
                          numbers("size", 0.5 * box.size), pose_xml(box.pose));
    if (options_.self_collision)
      for (const RobotDescription::LinkCapsule& c : b.capsules)
        text += capsule_xml(c.capsule, is_foot(robot_, i));
    if (names_) text += sites(i);
    for (int child = i + 1; child < static_cast<int>(robot_.bodies.size()); ++child)
      if (robot_.bodies[static_cast<std::size_t>(child)].parent == i) text += body(child);
    return text + "</body>\n";
  }
  // Joints in the order in which they were written.
  const std::vector<int>& order() const { return order_; }

 private:
  std::string sites(int i) const {
    std::string text = i == 0 ? "<site name=\"imu\"/>\n" : "";
    for (const auto& [name, sole] :
         {std::pair{"left_sole", &robot_.left_sole}, std::pair{"right_sole", &robot_.right_sole}})
      if (sole->body == i)
        text += fmt::format("<site name=\"{}\"{}/>\n", name, pose_xml(sole->pose));
    return text;
  }

  const FloatingRobot& robot_;
  const Plant::Options& options_;
  bool names_;
  std::vector<int> order_;
};

std::string motors_xml(const FloatingRobot& robot) {
  std::string text = "<actuator>\n";
  for (const FloatingRobot::Body& b : robot.bodies) {
    if (b.parent < 0) continue;
    text += fmt::format("<motor name=\"{0}\" joint=\"{0}\"", escaped(b.joint));
    if (b.effort < infinity)
      text += fmt::format(" ctrllimited=\"true\"{}",
                          numbers("ctrlrange", Vec<double, 2>(-b.effort, b.effort)));
    text += "/>\n";
  }
  return text + "</actuator>\n";
}

std::string key_xml(const WholeBodyState& start, const std::vector<int>& order) {
  VectorXd qpos(7 + start.q.size());
  const Eigen::Quaterniond q(start.base.linear());
  qpos.head<7>() << start.base.translation(), q.w(), q.x(), q.y(), q.z();
  for (std::size_t i = 0; i < order.size(); ++i)
    qpos[7 + static_cast<Eigen::Index>(i)] = start.q[order[i]];
  return fmt::format("<keyframe><key name=\"start\"{}/></keyframe>\n", numbers("qpos", qpos));
}

// Level ground is a plane: it has no edges and the cheapest collisions. The priority of boxes makes
// their friction that of the contact.
std::string ground_xml(const Plant::Options& options) {
  if (options.ground.is_level())
    return "<geom type=\"plane\" size=\"0 0 1\" contype=\"0\" conaffinity=\"1\"/>\n";
  std::string text;
  for (const GroundBox& box : ground_boxes(options)) {
    if (box.is_soft) continue;
    text +=
        fmt::format("<geom type=\"box\" contype=\"0\" conaffinity=\"1\" priority=\"1\"{}{}{}/>\n",
                    numbers("friction", Vec<double, 3>(box.friction, 0.0, 0.0)),
                    numbers("size", 0.5 * box.size), pose_xml(box.pose));
  }
  return text;
}

std::string model_xml(const FloatingRobot& robot, const Plant::Options& options,
                      const WholeBodyState* start) {
  BodyWriter writer(robot, options, start != nullptr);
  // Inertias are taken as given.
  std::string text = fmt::format(
                         "<mujoco>\n<compiler angle=\"radian\" inertiafromgeom=\"false\" "
                         "balanceinertia=\"false\"/>\n"
                         "<option timestep=\"{:.17g}\" gravity=\"0 0 {:.17g}\" cone=\"elliptic\" "
                         "impratio=\"{}\"/>\n"
                         "<default><joint armature=\"0\"/><geom condim=\"3\" solref=\"{} {}\" "
                         "friction=\"{:.17g} 0 0\"/></default>\n"
                         "<worldbody>\n",
                         options.step, -standard_gravity, friction_stiffness, contact_time,
                         contact_damping, options.friction) +
                     ground_xml(options) + writer.body(0) + "</worldbody>\n" +
                     (options.self_collision ? exclusions_xml(robot, start != nullptr) : "");
  if (start != nullptr)
    text += motors_xml(robot) +
            "<sensor><gyro name=\"gyroscope\" site=\"imu\"/>"
            "<accelerometer name=\"accelerometer\" site=\"imu\"/>"
            "<framequat name=\"orientation\" objtype=\"site\" objname=\"imu\"/></sensor>\n" +
            key_xml(*start, writer.order());
  return text + "</mujoco>\n";
}

}  // namespace

std::string to_mjcf(const FloatingRobot& robot, const Plant::Options& options) {
  return model_xml(robot, options, nullptr);
}
std::string to_mjcf(const FloatingRobot& robot, const Plant::Options& options,
                    const WholeBodyState& start) {
  return model_xml(robot, options, &start);
}

}  // namespace saltus::robots::mujoco_engine
