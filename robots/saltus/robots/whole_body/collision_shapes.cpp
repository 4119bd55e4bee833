#include "saltus/robots/whole_body/floating_robot.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "saltus/robots/model/capsule.hpp"
#include "saltus/robots/model/mesh.hpp"
#include "saltus/robots/whole_body/clearance.hpp"

namespace saltus::robots {
namespace {

constexpr double thinnest = 1e-3;  // m, radius: engines reject points
constexpr double touching = 0.01;  // m, distance of neighbours at rest
// joints between neighbours, such as from a hip to the third joint of the waist
constexpr int neighbourhood = 4;

std::vector<Vec<double, 3>> corners(const UrdfModel::Box& box) {
  UrdfModel::LinkShape shape;
  shape.pose = box.pose;
  shape.size = box.size;
  return hull_points(shape, {});
}

bool is_there(const UrdfModel::LinkShape& shape, const std::string& urdf) {
  return shape.shape != UrdfModel::LinkShape::Shape::mesh ||
         find_mesh(shape.mesh, urdf).has_value();
}

// Capsules fitted to a link, in its frame.
std::vector<Capsule> fitted(const UrdfModel::Link& link, const std::string& urdf) {
  std::vector<Capsule> capsules;
  for (const std::vector<UrdfModel::LinkShape>* shapes : {&link.visuals, &link.collisions}) {
    for (const UrdfModel::LinkShape& shape : *shapes) {
      if (!is_there(shape, urdf)) continue;
      const std::vector<Capsule> more = fit_capsules(hull_points(shape, urdf));
      capsules.insert(capsules.end(), more.begin(), more.end());
    }
    if (!capsules.empty()) break;
  }
  if (capsules.empty() && link.mass > 0.0) capsules = fit_capsules(corners(box_of_inertia(link)));
  for (Capsule& capsule : capsules) capsule.radius = std::max(capsule.radius, thinnest);
  return capsules;
}

// Number of joints between two bodies.
int joints_between(const FloatingRobot& robot, int a, int b) {
  int joints = 0;
  while (a != b) {
    int& later = a > b ? a : b;  // parents precede their children
    later = robot.bodies[static_cast<std::size_t>(later)].parent;
    ++joints;
  }
  return joints;
}

WholeBodyState at_rest(const FloatingRobot& robot) {
  WholeBodyState state;
  state.q = state.dq = VectorXd::Zero(robot.joints());
  for (int i = 0; i < robot.joints(); ++i) {
    const Bounds& limits = robot.bodies[static_cast<std::size_t>(i) + 1].position;
    state.q[i] = std::clamp(0.0, limits.lower, limits.upper);
  }
  return state;
}

}  // namespace

void add_capsules(FloatingRobot& robot, const UrdfModel& model,
                  const RobotDescription& description) {
  const auto add = [&](const std::string& link, const Capsule& capsule) {
    const FloatingRobot::Frame frame = link_frame(robot, model, link);
    robot.bodies[static_cast<std::size_t>(frame.body)].capsules.push_back(
        {link, frame.pose * capsule});
  };
  for (FloatingRobot::Body& body : robot.bodies) body.capsules.clear();
  for (const RobotDescription::LinkCapsule& c : description.capsules) add(c.link, c.capsule);
  if (description.capsules.empty())
    for (const UrdfModel::Link& link : model.links())
      for (const Capsule& capsule : fitted(link, model.source())) add(link.name, capsule);

  // Add all pairs first. The pairs that are near at rest are found among them.
  robot.apart.clear();
  const int bodies = static_cast<int>(robot.bodies.size());
  for (int a = 0; a < bodies; ++a)
    for (int b = a + 1; b < bodies; ++b)
      if (joints_between(robot, a, b) > 1) robot.apart.emplace_back(a, b);
  constexpr int all = 1000;
  Clearance clearance(robot, all);
  clearance.update(at_rest(robot), touching);
  for (int i = 0; i < clearance.count(); ++i) {
    const auto body = [&](int member) {
      return clearance.members()[static_cast<std::size_t>(member)].body;
    };
    const std::pair<int, int> pair{body(clearance.approach(i).first),
                                   body(clearance.approach(i).second)};
    if (joints_between(robot, pair.first, pair.second) <= neighbourhood)
      robot.apart.erase(std::remove(robot.apart.begin(), robot.apart.end(), pair),
                        robot.apart.end());
  }
}

void expect_apart(const FloatingRobot& robot, const WholeBodyState& state,
                  const std::string& posture) {
  Clearance clearance(robot, 1);
  clearance.update(state);
  if (clearance.count() == 0 || clearance.approach(0).distance >= 0.0) return;
  throw InputError(
      fmt::format("{}: in the posture \"{}\" the links {} overlap by {:.0f} mm; change the "
                  "posture, or set self_collision=false",
                  robot.source, posture, clearance.names(clearance.approach(0)),
                  -1e3 * clearance.approach(0).distance));
}

}  // namespace saltus::robots
