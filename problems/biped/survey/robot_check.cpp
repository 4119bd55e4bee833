#include "problems/biped/survey/robot_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <optional>
#include <set>

#include "problems/biped/survey/plausibility.hpp"
#include "problems/biped/survey/posture_search.hpp"
#include "saltus/core/text.hpp"
#include "saltus/robots/model/capture_point.hpp"
#include "saltus/robots/model/foot.hpp"
#include "saltus/robots/model/mesh.hpp"
#include "saltus/robots/whole_body/clearance.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::survey {
namespace {

constexpr double millimetres = 1e3;

class Check {
 public:
  Check(const robots::UrdfModel& model, const robots::RobotDescription& robot)
      : model_(model), robot_(robot) {}

  std::vector<Finding> run(double forward, Bounds sideways) {
    if (!masses()) return std::move(findings_);
    check_plausibility(model_, robot_, body_, findings_);
    limits();
    meshes();
    feet();
    for (const robots::StandingPosture& p : robot_.postures) posture(p);
    reach(forward, sideways);
    return std::move(findings_);
  }

 private:
  bool masses() {
    Subject masses(findings_, "masses");
    try {
      body_ = robots::floating_robot(model_, robot_);
    } catch (const InputError& error) {
      masses.wrong(error.what());
      return false;
    }
    try {
      robots::add_capsules(body_, model_, robot_);
      has_capsules_ = true;
    } catch (const InputError& error) {
      Subject(findings_, "limbs").note(error.what());
    }
    constexpr double trifle =
        1e-4;  // relative to the robot's mass; a lighter body makes the mass matrix ill-conditioned
    constexpr double spread = 0.6;  // relative to the robot's height; no link is that large
    for (const robots::FloatingRobot::Body& b : body_.bodies) {
      if (b.mass < trifle * body_.total_mass)
        masses.note(fmt::format(
            "the links that move with \"{}\" have a mass of {:.2g} kg; freeze its joint or "
            "correct its <inertial>",
            b.name, b.mass));
      const double gyration = std::sqrt(b.inertia.trace() / (2.0 * b.mass));
      if (gyration > spread * height())
        masses.note(
            fmt::format("\"{}\" has a radius of gyration of {:.2f} m, more than a link of "
                        "this robot can have; correct its <inertia>",
                        b.name, gyration));
    }
    masses.good(fmt::format("{:.2f} kg in {} bodies, all inertias are physically possible",
                            body_.total_mass, body_.bodies.size()));
    return true;
  }

  void limits() {
    Subject limits(findings_, "limits");
    const double weight = body_.total_mass * robots::standard_gravity;
    std::vector<std::string> unlimited;
    for (int i = 0; i < body_.joints(); ++i) {
      const robots::FloatingRobot::Body& b = body_.bodies[static_cast<std::size_t>(i) + 1];
      if (b.effort > 2.0 * weight * height()) unlimited.push_back(b.joint);
    }
    if (!unlimited.empty())
      limits.note(
          fmt::format("the effort limits of {} have no effect, because they could lift two such "
                      "robots at arm's length; set those of the motors under joints in {}",
                      join_names(unlimited), robot_.file));
    limits.good(fmt::format("{} actuated joints, all with limits", body_.joints()));
  }

  void meshes() {
    Subject meshes(findings_, "meshes");
    std::set<std::string> seen, missing;
    for (const robots::UrdfModel::Link& link : model_.links())
      for (const auto* shapes : {&link.collisions, &link.visuals})
        for (const robots::UrdfModel::LinkShape& shape : *shapes) {
          if (shape.shape != robots::UrdfModel::LinkShape::Shape::mesh ||
              !seen.insert(shape.mesh).second)
            continue;
          if (!robots::find_mesh(shape.mesh, model_.source())) missing.insert(shape.mesh);
        }
    if (!missing.empty())
      meshes.note(
          fmt::format("{} of {} are missing, the first is {}; put their package next to the URDF, "
                      "or add the folder of packages to ROS_PACKAGE_PATH",
                      missing.size(), seen.size(), *missing.begin()));
    meshes.good(fmt::format("{}, all found", seen.size()));
  }

  void feet() {
    Subject feet(findings_, "feet");
    constexpr double same = 1e-3;  // m
    const robots::FootRectangle image = robot_.right_foot.mirrored();
    const robots::FootRectangle& left = robot_.left_foot;
    if (std::abs(image.x.lower - left.x.lower) > same ||
        std::abs(image.x.upper - left.x.upper) > same ||
        std::abs(image.y.lower - left.y.lower) > same ||
        std::abs(image.y.upper - left.y.upper) > same)
      feet.note("the left and right foot are not mirror images of each other; check their shapes");
    for (const robots::Side side : {robots::Side::left, robots::Side::right}) {
      const std::string& sole = robot_.sole(side);
      const std::optional<double> plane = model_.has_collision_box(sole)
                                              ? model_.foot(sole).contact_plane_offset
                                              : lowest_point(model_, sole);
      const double off = plane ? robot_.contact_plane_offset - *plane : 0.0;
      if (std::abs(off) > same)
        feet.wrong(fmt::format(
            "the contact plane of the {} foot is {:.1f} mm {} its shape: the plane is {:.4f} m "
            "along z of "
            "\"{}\", its lowest points are at {:.4f} m; correct contact_plane_offset in {}",
            name_of(side), millimetres * std::abs(off), off < 0.0 ? "above" : "inside",
            robot_.contact_plane_offset, robot_.sole(side), *plane, robot_.file));
    }
    feet.good(fmt::format(
        "{:.0f} x {:.0f} mm below \"{}\" and \"{}\"", millimetres * (left.x.upper - left.x.lower),
        millimetres * (left.y.upper - left.y.lower), robot_.left_sole, robot_.right_sole));
  }

  // Runs start from the first posture on that foot, or on both. Other postures have other uses.
  bool is_a_start(const robots::StandingPosture& posture) const {
    return &posture == &*std::find_if(robot_.postures.begin(), robot_.postures.end(),
                                      [&](const auto& p) { return p.stance == posture.stance; });
  }

  void posture(const robots::StandingPosture& p) {
    Subject subject(findings_, p.name);
    try {
      clearance(p, robots::standing_state(body_, model_, robot_, p), subject);
    } catch (const InputError& error) {
      if (is_a_start(p))
        subject.wrong(error.what());
      else
        subject.note(error.what());
      return;
    }
    const robots::Side side = p.side();
    const robots::PlacedFoot stance{robots::flat_sole(Vec<double, 3>::Zero()), robot_.foot(side)};
    const robots::PlacedFoot swing{robots::flat_sole(p.other_foot), robot_.foot(other(side))};
    const robots::SupportPolygon ground = p.stance == robots::Stance::both
                                              ? robots::SupportPolygon::under({stance, swing})
                                              : robots::SupportPolygon::under({stance});
    const double margin = -ground.signed_distance(p.com.head<2>());
    constexpr double least = 0.005, level = 2e-3;  // m
    if (margin < 0.0)
      subject.wrong(
          fmt::format("the CoM is {:.1f} mm outside the support polygon, so the robot falls; "
                      "change the joints of the posture in {}",
                      -millimetres * margin, robot_.file));
    else if (margin < least)
      subject.note(fmt::format("the CoM is only {:.1f} mm inside the support polygon",
                               millimetres * margin));
    if (p.stance == robots::Stance::both && std::abs(p.other_foot.z()) > level)
      subject.wrong(fmt::format("the feet differ in height by {:.1f} mm; one of them is in the air",
                                millimetres * p.other_foot.z()));
    if (p.stance != robots::Stance::both && p.other_foot.z() < -level)
      subject.wrong(fmt::format("the lifted foot is {:.1f} mm below the ground",
                                -millimetres * p.other_foot.z()));
    subject.good(fmt::format("CoM {:.3f} m high, {:.0f} mm inside the support polygon", p.com.z(),
                             millimetres * margin));
  }

  // Checks the clearance between limbs that must not touch.
  void clearance(const robots::StandingPosture& p, const robots::WholeBodyState& state,
                 Subject& subject) {
    if (!has_capsules_) return;
    robots::Clearance limbs(body_, 1);
    limbs.update(state);
    if (limbs.count() == 0) return;
    const robots::Approach& nearest = limbs.approach(0);
    constexpr double little = 0.005;  // m
    if (nearest.distance < 0.0)
      std::invoke(is_a_start(p) ? &Subject::wrong : &Subject::note, subject,
                  fmt::format("{} overlap by {:.1f} mm; change the joints of the posture, or the "
                              "capsules, in {}",
                              limbs.names(nearest), -millimetres * nearest.distance, robot_.file));
    else if (nearest.distance < little)
      subject.note(fmt::format("{} are only {:.1f} mm apart", limbs.names(nearest),
                               millimetres * nearest.distance));
  }

  void reach(double forward, Bounds sideways) {
    Subject reach(findings_, "reach");
    const auto posture =
        std::find_if(robot_.postures.begin(), robot_.postures.end(),
                     [](const auto& p) { return p.stance == robots::Stance::left; });
    if (posture == robot_.postures.end()) {
      reach.note("not checked: there is no posture on the left foot");
      return;
    }
    const std::vector<Eigen::Isometry3d> poses = model_.link_poses(posture->joints);
    Eigen::Isometry3d sole = poses[static_cast<std::size_t>(model_.link_index(robot_.left_sole))];
    sole.translate(Vec<double, 3>(0.0, 0.0, robot_.contact_plane_offset));
    PostureWish wish;
    wish.stance = robots::Side::left;
    wish.trunk_height = sole.inverse().translation().z();
    wish.clearance = 0.0;
    std::string missed;
    for (const double x : {-forward, 0.0, forward})
      for (const double y : {sideways.lower, sideways.upper}) {
        if (x != 0.0 && y == sideways.upper) continue;  // the corner itself is not required
        wish.other_foot = {x, -y, 0.0};
        wish.com = 0.5 * wish.other_foot.head<2>();
        const FoundPosture found = find_posture(model_, robot_, body_, wish, posture->joints);
        if (!found.is_found())
          missed += fmt::format("{}({:.2f}, {:.2f})", missed.empty() ? "" : ", ", x, y);
      }
    if (!missed.empty())
      reach.note(
          fmt::format("with both soles flat, the feet do not reach (forward, away) = {} m; narrow "
                      "step.forward_max, step.lateral_min and step.lateral_max",
                      missed));
    reach.good(fmt::format("steps of {:.2f} m forward and back, {:.2f} to {:.2f} m apart", forward,
                           sideways.lower, sideways.upper));
  }

  double height() const {
    double most = 0.0;
    for (const robots::StandingPosture& p : robot_.postures) most = std::max(most, 2.0 * p.com.z());
    return most;
  }

  const robots::UrdfModel& model_;
  const robots::RobotDescription& robot_;
  robots::FloatingRobot body_;
  bool has_capsules_ = false;
  std::vector<Finding> findings_;
};

}  // namespace

std::vector<Finding> check_robot(const robots::UrdfModel& model,
                                 const robots::RobotDescription& robot, double forward,
                                 Bounds sideways) {
  return Check(model, robot).run(forward, sideways);
}

std::string describe(std::span<const Finding> findings) {
  constexpr std::array words{"ok", "note", "WRONG"};
  std::string text;
  for (const Finding& f : findings)
    text +=
        fmt::format("{:<6}{:<14}{}\n", words[static_cast<std::size_t>(f.level)], f.subject, f.text);
  return text;
}

}  // namespace saltus::survey
