#include "saltus/robots/whole_body/floating_robot.hpp"

#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

#include "saltus/core/text.hpp"

namespace saltus::robots {
namespace {

std::string suggestion(const std::string& name, const std::vector<std::string>& known) {
  const std::string near = nearest_name(name, known);
  return near.empty() ? "" : fmt::format("; did you mean \"{}\"?", near);
}

Mat<double, 3, 3> parallel_axis(double mass, const Vec<double, 3>& r) {
  return mass * (r.squaredNorm() * Mat<double, 3, 3>::Identity() - r * r.transpose());
}

// Adds a mass to a body. All arguments are in the body's frame.
void merge(FloatingRobot::Body& body, double mass, const Vec<double, 3>& com,
           const Mat<double, 3, 3>& inertia) {
  if (mass <= 0.0) return;
  const double total = body.mass + mass;
  const Vec<double, 3> centre = (body.mass * body.com + mass * com) / total;
  body.inertia = body.inertia + parallel_axis(body.mass, body.com - centre) + inertia +
                 parallel_axis(mass, com - centre);
  body.com = centre;
  body.mass = total;
}

// Models for simulators often inflate the inertias of small links. No part of a standing robot has
// a lower density.
constexpr double least_density = 500.0;  // kg/m^3

FloatingRobot::Look look_of(const UrdfModel::Link& link, const Eigen::Isometry3d& in_body) {
  FloatingRobot::Look look{link.name, link.visuals, link.collision_boxes};
  if (look.boxes.empty() && link.mass > 0.0) look.boxes.push_back(box_of_inertia(link));
  for (UrdfModel::LinkShape& visual : look.visuals) visual.pose = in_body * visual.pose;
  for (UrdfModel::Box& box : look.boxes) box.pose = in_body * box.pose;
  return look;
}

// Thin box on the rectangle of a contact frame, above the contact plane.
UrdfModel::Box thin_box(const Eigen::Isometry3d& contact, const FootRectangle& foot) {
  constexpr double thickness = 0.005;  // m; larger than the penetration that engines allow
  UrdfModel::Box box;
  box.size = {foot.x.upper - foot.x.lower, foot.y.upper - foot.y.lower, thickness};
  box.pose = contact;
  box.pose.translate(Vec<double, 3>(0.5 * (foot.x.lower + foot.x.upper),
                                    0.5 * (foot.y.lower + foot.y.upper), 0.5 * thickness));
  return box;
}

const RobotDescription::Joint* actuated(const RobotDescription& robot, const std::string& joint) {
  for (const RobotDescription::Joint& a : robot.joints)
    if (a.name == joint) return &a;
  return nullptr;
}

// Checks the limits of an actuated joint.
void check_limits(const FloatingRobot::Body& body, const std::string& urdf,
                  const std::string& file) {
  if (!(body.effort > 0.0))
    throw InputError(
        fmt::format("{}: joint \"{}\" has an effort limit of {} Nm, so its motor has no effect; "
                    "set a positive one in its <limit>, or under joints in {}",
                    urdf, body.joint, body.effort, file));
  if (!(body.position.lower <= body.position.upper))
    throw InputError(
        fmt::format("{}: joint \"{}\" has the empty range of {:.4g} to {:.4g} rad; correct its "
                    "<limit>, or set its position under joints in {}",
                    urdf, body.joint, body.position.lower, body.position.upper, file));
}

}  // namespace

int FloatingRobot::joint_index(const std::string& joint) const {
  std::vector<std::string> known;
  for (int i = 0; i < joints(); ++i) {
    if (bodies[i + 1].joint == joint) return i;
    known.push_back(bodies[i + 1].joint);
  }
  throw InputError(fmt::format("{}: there is no actuated joint \"{}\"{}", name, joint,
                               suggestion(joint, known)));
}

int FloatingRobot::body_index(const std::string& body) const {
  std::vector<std::string> known;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].name == body) return static_cast<int>(i);
    known.push_back(bodies[i].name);
  }
  throw InputError(
      fmt::format("{}: there is no link \"{}\"{}", name, body, suggestion(body, known)));
}

VectorXd FloatingRobot::joint_positions(const Posture& posture) const {
  VectorXd q = VectorXd::Zero(joints());
  for (const auto& [joint, position] : posture) q[joint_index(joint)] = position;
  return q;
}

FloatingRobot floating_robot(const UrdfModel& model, const RobotDescription& robot) {
  const std::vector<UrdfModel::Link>& links = model.links();
  const std::vector<std::string> moving = model.moving_joint_names();
  for (const RobotDescription::Joint& a : robot.joints)
    if (std::find(moving.begin(), moving.end(), a.name) == moving.end())
      throw InputError(fmt::format("{}: there is no movable joint \"{}\"{}", model.source(), a.name,
                                   suggestion(a.name, moving)));

  const auto missing = [&](const char* key, const char* what) {
    throw InputError(fmt::format("{}: {} is missing; name {}", robot.file, key, what));
  };
  if (robot.base.empty()) missing("base", "the link of the floating base");
  if (robot.joints.empty()) missing("joints", "the actuated joints");

  FloatingRobot result;
  result.name = robot.name;
  result.source = model.source();
  // Maps every link to its body and its pose in the body's frame.
  std::vector<int> body_of(links.size(), 0);
  std::vector<Eigen::Isometry3d> pose(links.size(), Eigen::Isometry3d::Identity());
  for (std::size_t i = 0; i < links.size(); ++i) {
    const UrdfModel::Link& link = links[i];
    const RobotDescription::Joint* motor =
        link.parent < 0 ? nullptr : actuated(robot, link.joint.name);
    if (link.parent < 0 || motor != nullptr) {
      FloatingRobot::Body body;
      body.name = link.name;
      if (motor != nullptr) {
        body.parent = body_of[link.parent];
        body.joint = link.joint.name;
        body.origin = pose[link.parent] * link.joint.origin;
        body.axis = link.joint.axis;
        body.position = motor->position.value_or(link.joint.position);
        body.effort = motor->effort.value_or(link.joint.effort);
        body.velocity = motor->velocity.value_or(link.joint.velocity);
        body.drive = motor->drive;
        if (!link.joint.leader.empty())
          throw InputError(fmt::format(
              "{}: joint \"{}\" follows \"{}\" by <mimic>, so it has no motor of its own; remove "
              "it from joints in {}, or remove its <mimic>",
              model.source(), body.joint, link.joint.leader, robot.file));
        check_limits(body, model.source(), robot.file);
      }
      body_of[i] = static_cast<int>(result.bodies.size());
      result.bodies.push_back(std::move(body));
    } else {
      body_of[i] = body_of[link.parent];
      pose[i] = pose[link.parent] * link.joint.origin;
    }
    FloatingRobot::Body& body = result.bodies[body_of[i]];
    const Mat<double, 3, 3> R = pose[i].linear();
    if (link.mass > 0.0)
      merge(body, link.mass, pose[i] * link.com, R * link.inertia * R.transpose());
    for (const UrdfModel::Box& box : link.collision_boxes)
      body.boxes.push_back({pose[i] * box.pose, box.size});
    if (!link.visuals.empty()) body.looks.push_back(look_of(link, pose[i]));
    result.total_mass += link.mass;
    // Users may name any link of a group. The base is named as in the file.
    if (link.name == robot.base) {
      if (body_of[i] != 0)
        throw InputError(
            fmt::format("{}: \"{}\" is not fixed to the root link \"{}\"; name a base that is",
                        model.source(), robot.base, links.front().name));
      result.bodies.front().name = link.name;
    }
  }
  model.link_index(robot.base);  // throws if there is none
  const auto sole = [&](const std::string& link) {
    const int i = model.link_index(link);
    FloatingRobot::Frame frame{body_of[i], pose[i]};
    frame.pose.translate(Vec<double, 3>(0.0, 0.0, robot.contact_plane_offset));
    return frame;
  };
  result.left_sole = sole(robot.left_sole);
  result.right_sole = sole(robot.right_sole);
  for (const Side side : {Side::left, Side::right})
    if (!model.has_collision_box(robot.sole(side))) {
      const FloatingRobot::Frame& frame = side == Side::left ? result.left_sole : result.right_sole;
      result.bodies[static_cast<std::size_t>(frame.body)].boxes.push_back(
          thin_box(frame.pose, robot.foot(side)));
    }
  for (const FloatingRobot::Body& b : result.bodies)
    if (!(b.mass > 0.0))
      throw InputError(fmt::format("{}: the links that move with joint \"{}\" have no mass",
                                   model.source(), b.joint));
  return result;
}

FloatingRobot::Frame link_frame(const FloatingRobot& robot, const UrdfModel& model,
                                const std::string& link) {
  FloatingRobot::Frame frame;
  for (int i = model.link_index(link);; i = model.links()[i].parent) {
    const UrdfModel::Link& l = model.links()[i];
    if (l.parent < 0) return frame;  // moves with the base
    for (std::size_t b = 1; b < robot.bodies.size(); ++b)
      if (robot.bodies[b].joint == l.joint.name) {
        frame.body = static_cast<int>(b);
        return frame;
      }
    frame.pose = l.joint.origin * frame.pose;
  }
}

UrdfModel::Box box_of_inertia(const UrdfModel::Link& link) {
  const Eigen::SelfAdjointEigenSolver<Mat<double, 3, 3>> axes(link.inertia);
  Mat<double, 3, 3> R = axes.eigenvectors();
  if (R.determinant() < 0.0) R.col(0) *= -1.0;
  UrdfModel::Box box;
  box.pose.translation() = link.com;
  box.pose.linear() = R;
  // I_x = m (b^2 + c^2) / 12, and so on.
  const Vec<double, 3>& I = axes.eigenvalues();
  box.size = ((I.sum() - 2.0 * I.array()).max(0.0) * 6.0 / link.mass).sqrt();
  const double lightest = box.size.prod() * least_density;
  if (lightest > link.mass) box.size *= std::cbrt(link.mass / lightest);
  return box;
}

FloatingRobot with_masses_scaled(FloatingRobot robot, double factor) {
  for (FloatingRobot::Body& body : robot.bodies) {
    body.mass *= factor;
    body.inertia *= factor;
  }
  robot.total_mass *= factor;
  return robot;
}

FloatingRobot with_com_shifted(FloatingRobot robot, const Vec<double, 3>& shift) {
  FloatingRobot::Body& base = robot.bodies.front();
  base.com += robot.total_mass / base.mass * shift;
  return robot;
}

FloatingRobot with_drives_scaled(FloatingRobot robot, const DriveFactors& factors) {
  bool is_ideal = true, is_rigid = true, has_backlash = false;
  for (FloatingRobot::Body& body : robot.bodies) {
    body.drive = factors(body.drive);
    is_ideal = is_ideal && body.drive.is_ideal();
    is_rigid = is_rigid && body.drive.stiffness == infinity;
    has_backlash = has_backlash || body.drive.backlash > 0.0;
  }
  if (is_ideal && !factors.is_ideal())
    throw InputError(fmt::format(
        "{}: no joint has the requested figures of a drive; add rotor_inertia, dry_friction, "
        "stall_torque or no_load_speed to the joints in its file, or simulate ideal drives",
        robot.name));
  const auto missing = [&robot](const char* requested, const char* key) {
    throw InputError(fmt::format(
        "{}: {} of the drives is requested, but no joint has a {}; add it to the joints in its "
        "file, or leave it out",
        robot.name, requested, key));
  };
  if (is_rigid && factors.elasticity > 0.0) missing("elasticity", "stiffness");
  if (!has_backlash && factors.backlash > 0.0) missing("backlash", "backlash");
  return robot;
}

WholeBodyState standing_state(const FloatingRobot& robot, const UrdfModel& model,
                              const RobotDescription& description, const StandingPosture& posture) {
  WholeBodyState state;
  Eigen::Isometry3d sole =
      model.link_pose(description.sole(posture.side()), model.links().front().name, posture.joints);
  sole.translate(Vec<double, 3>(0.0, 0.0, description.contact_plane_offset));
  state.base = sole.inverse();
  state.q = robot.joint_positions(posture.joints);
  state.dq = VectorXd::Zero(robot.joints());
  for (int i = 0; i < robot.joints(); ++i) {
    const FloatingRobot::Body& driven = robot.bodies[static_cast<std::size_t>(i) + 1];
    if (state.q[i] >= driven.position.lower && state.q[i] <= driven.position.upper) continue;
    throw InputError(fmt::format(
        "{}: the posture \"{}\" has joint \"{}\" at {:.4g} rad, outside its limits {:.4g} "
        "to {:.4g} rad; change the posture or the limits",
        model.source(), posture.name, driven.joint, state.q[i], driven.position.lower,
        driven.position.upper));
  }
  return state;
}

}  // namespace saltus::robots
