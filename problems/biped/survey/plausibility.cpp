#include "problems/biped/survey/plausibility.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <utility>

#include "problems/biped/survey/leg.hpp"
#include "saltus/core/text.hpp"

namespace saltus::survey {
namespace {

constexpr double millimetres = 1e3;
using Body = robots::FloatingRobot::Body;

std::string text_of(const Bounds& range) {
  return fmt::format("{:.4g} to {:.4g} rad", range.lower, range.upper);
}

// The first names and the number of the others.
std::string few(std::vector<std::string> names) {
  constexpr std::size_t most = 4;
  const std::size_t others = names.size() > most ? names.size() - most : 0;
  names.resize(names.size() - others);
  for (std::string& name : names) name = fmt::format("\"{}\"", name);
  if (others > 0) names.push_back(fmt::format("{} more", others));
  return join_names(names);
}

class Plausibility {
 public:
  Plausibility(const robots::UrdfModel& model, const robots::RobotDescription& robot,
               const robots::FloatingRobot& body, std::vector<Finding>& findings)
      : model_(model),
        robot_(robot),
        body_(body),
        findings_(findings),
        poses_(model.link_poses({})),
        legs_{find_leg(model, robot.left_sole), find_leg(model, robot.right_sole)} {}

  void run() {
    units();
    joints();
    sides();
    knees();
  }

 private:
  // Twice the height of the CoM, m. A humanoid is a little lower.
  double height() const {
    double most = 0.0;
    for (const robots::StandingPosture& p : robot_.postures) most = std::max(most, 2.0 * p.com.z());
    return most;
  }

  // True for the bodies with a visual or collision shape, from which capsules are made.
  std::vector<bool> with_shapes() const {
    std::vector<bool> result(body_.bodies.size(), false);
    for (const robots::UrdfModel::Link& link : model_.links())
      if (!link.visuals.empty() || !link.collisions.empty())
        result[static_cast<std::size_t>(robots::link_frame(body_, model_, link.name).body)] = true;
    return result;
  }

  void units() {
    Subject units(findings_, "units");
    // m, heights of humanoids
    constexpr double lowest = 0.2, highest = 3.0;
    // kg/m^3, mass divided by the cube of the height. Published robots have 6 (Poppy: 3.5 kg,
    // 0.83 m) to 30 (iCub: 33 kg, 1.04 m), a person 13.
    constexpr double lightest = 2.0, heaviest = 120.0;
    const double h = height(), stout = body_.total_mass / (h * h * h);
    if (h > 0.0 && (h < lowest || h > highest))
      units.wrong(fmt::format(
          "the robot is about {:.3g} m high, but humanoids are {} to {} m high; write lengths in m",
          h, lowest, highest));
    else if (h > 0.0 && (stout < lightest || stout > heaviest))
      units.wrong(
          fmt::format("a robot about {:.2f} m high with {:.4g} kg is too {}: mass divided by "
                      "height^3 is {:.3g} kg/m^3, that of humanoids 6 to 30; write masses in kg",
                      h, body_.total_mass, stout < lightest ? "light" : "heavy", stout));

    // kg/m^3. The shape encloses the body, so the body is denser still.
    constexpr double lead = 11340.0;
    constexpr double trifle = 0.005, main = 0.1;  // fractions of the robot's mass
    constexpr double outside = 1.2;               // radius of gyration divided by that of the shape
    const std::vector<bool> has_shape = with_shapes();
    double densest = 0.0;
    std::vector<std::string> dense, spread;
    for (std::size_t i = 0; i < body_.bodies.size(); ++i) {
      const Body& b = body_.bodies[i];
      if (!has_shape[i] || b.capsules.empty() || b.mass < trifle * body_.total_mass) continue;
      double volume = 0.0, radius = 0.0;
      for (const robots::UrdfModel::Box& box : b.boxes) {
        volume += box.size.prod();
        radius = std::max(radius, (box.pose.translation() - b.com).norm() + 0.5 * box.size.norm());
      }
      for (const robots::RobotDescription::LinkCapsule& c : b.capsules) {
        volume += c.capsule.volume();
        for (const Vec<double, 3>& end : {c.capsule.from, c.capsule.to})
          radius = std::max(radius, (end - b.com).norm() + c.capsule.radius);
      }
      const double density = b.mass / volume;
      densest = std::max(densest, density);
      if (density > lead && b.mass > main * body_.total_mass)
        units.wrong(
            fmt::format("\"{}\" has {:.4g} kg in a shape of {:.3g} litres, so it is denser than "
                        "lead; correct its <mass> (kg) or its shape (m)",
                        b.name, b.mass, 1e3 * volume));
      else if (density > lead)
        dense.push_back(b.name);
      if (std::sqrt(b.inertia.trace() / (2.0 * b.mass)) > outside * radius)
        spread.push_back(b.name);
    }
    if (!dense.empty())
      units.note(fmt::format(
          "{} are denser than lead; correct their <mass> (kg) or their shapes (m)", few(dense)));
    if (!spread.empty())
      units.note(fmt::format(
          "the radii of gyration of {} exceed their shapes; correct their <inertia> (kg m^2)",
          few(spread)));
    units.good(fmt::format("{:.1f} kg at a height of about {:.2f} m, no link above {:.0f} kg/m^3",
                           body_.total_mass, h, densest));
  }

  bool is_driven(const std::string& joint) const {
    return std::any_of(body_.bodies.begin(), body_.bodies.end(),
                       [&](const Body& b) { return b.joint == joint; });
  }

  // Mass of the link and of all links that it carries, kg.
  double carried_mass(std::size_t first) const {
    std::vector<bool> carried(model_.links().size(), false);
    double mass = 0.0;
    for (std::size_t i = first; i < carried.size(); ++i) {
      const robots::UrdfModel::Link& link = model_.links()[i];
      carried[i] =
          i == first || (link.parent >= 0 && carried[static_cast<std::size_t>(link.parent)]);
      if (carried[i]) mass += link.mass;
    }
    return mass;
  }

  void joints() {
    Subject joints(findings_, "joints");
    constexpr double limb = 0.012;     // fraction of the robot's mass
    constexpr double rounding = 1e-3;  // rad or m
    int frozen = 0;
    std::vector<std::string> coupled, light;
    for (std::size_t i = 0; i < model_.links().size(); ++i) {
      const robots::UrdfModel::Joint& joint = model_.links()[i].joint;
      if (joint.motion == robots::UrdfModel::Joint::Motion::fixed || is_driven(joint.name))
        continue;
      ++frozen;
      if (!joint.leader.empty() && is_driven(joint.leader)) coupled.push_back(joint.name);
      const double off = std::max(joint.position.lower, -joint.position.upper);
      if (!(off > rounding)) continue;
      if (carried_mass(i) > limb * model_.total_mass())
        joints.wrong(
            fmt::format("\"{}\" is frozen at zero, {:.3g} rad outside its limits; list it under "
                        "joints in {}, or move its zero between the limits with its <origin>",
                        joint.name, off, robot_.file));
      else
        light.push_back(joint.name);
    }
    if (!coupled.empty())
      joints.note(fmt::format(
          "{} follow moving joints by <mimic>, but stay at zero here, because coupled "
          "joints are not simulated; make them fixed, or give them motors instead of <mimic>",
          few(coupled)));
    if (!light.empty())
      joints.note(fmt::format(
          "{} are frozen at zero, outside their limits; move their zeros between the limits with "
          "their <origin>",
          few(light)));
    joints.good(fmt::format("{} with motors, {} frozen at zero", body_.joints(), frozen));
  }

  // Bodies of the left and the right side that are mirror images: in the legs by their order, in
  // other limbs by the names of their joints.
  std::vector<std::pair<const Body*, const Body*>> pairs() const {
    std::map<std::string, const Body*> bodies;
    for (const Body& b : body_.bodies)
      if (b.parent >= 0) bodies[b.joint] = &b;
    const auto body_at = [&](int link) -> const Body* {
      const auto found = bodies.find(model_.links()[static_cast<std::size_t>(link)].joint.name);
      return found == bodies.end() ? nullptr : found->second;
    };
    std::vector<std::pair<const Body*, const Body*>> result;
    const auto add = [&](const Body* left, const Body* right) {
      if (left != nullptr && right != nullptr && left != right) result.emplace_back(left, right);
    };
    const std::vector<int>&left = legs_[0].joints, &right = legs_[1].joints;
    if (left.size() == right.size())
      for (std::size_t k = 0; k < left.size(); ++k) add(body_at(left[k]), body_at(right[k]));
    const auto is_of_leg = [&](const Body* b) {
      return std::any_of(result.begin(), result.end(),
                         [&](const auto& pair) { return pair.first == b || pair.second == b; });
    };
    if (!robot_.mirror) return result;
    for (const auto& [name, b] : bodies) {
      const auto twin = bodies.find(robot_.mirror->namesake(name));
      if (twin == bodies.end() || !(name < twin->first) || is_of_leg(b)) continue;
      add(b, twin->second);
    }
    return result;
  }

  void sides() {
    Subject sides(findings_, "sides");
    constexpr double same_mass = 0.05;       // relative difference
    constexpr double same_place = 0.01;      // m
    constexpr double same_length = 2e-3;     // m
    constexpr double same_limit = 0.02;      // rad
    constexpr double same_effort = 0.05;     // relative difference
    constexpr double same_direction = 0.99;  // cosine
    const Eigen::Isometry3d to_sole = poses_[static_cast<std::size_t>(legs_[0].sole)].inverse();
    const Eigen::Isometry3d to_other = poses_[static_cast<std::size_t>(legs_[1].sole)].inverse();
    const double middle = 0.5 * (to_sole * to_other.inverse()).translation().y();
    const Vec<double, 3> reflection(1.0, -1.0, 1.0);
    // First difference of each kind, and the number of pairs that differ.
    std::array<std::pair<std::string, int>, 5> kinds;
    const auto differ = [&](std::size_t kind, const std::string& text) {
      if (kinds[kind].second++ == 0) kinds[kind].first = text;
    };
    const auto pose_of = [&](const Body& b) {
      return to_sole * poses_[static_cast<std::size_t>(model_.link_index(b.name))];
    };
    const auto unlike = [](double a, double b) {
      return std::abs(a - b) / std::max(std::abs(a), std::abs(b));
    };
    const std::vector<std::pair<const Body*, const Body*>> all = pairs();
    for (const auto& [one, two] : all) {
      if (unlike(one->mass, two->mass) > same_mass)
        differ(0, fmt::format("\"{}\" has {:.4g} kg and \"{}\" {:.4g} kg", one->name, one->mass,
                              two->name, two->mass));
      Vec<double, 3> here = pose_of(*one) * one->com, there = pose_of(*two) * two->com;
      here.y() -= middle;
      there.y() -= middle;
      const double apart = (reflection.cwiseProduct(here) - there).norm();
      if (apart > same_place)
        differ(1,
               fmt::format("the CoMs of \"{}\" and \"{}\" are {:.0f} mm from being mirror images",
                           one->name, two->name, millimetres * apart));
      // A reflection turns the axis a of a joint into -S a, S = diag(1, -1, 1).
      const Vec<double, 3> image =
          -reflection.cwiseProduct(Vec<double, 3>(pose_of(*one).linear() * one->axis));
      const double along = image.dot(pose_of(*two).linear() * two->axis);
      if (std::abs(along) < same_direction)
        differ(2, fmt::format("the axes of joints \"{}\" and \"{}\" are {:.2f} rad apart",
                              one->joint, two->joint, std::acos(std::min(std::abs(along), 1.0))));
      const Bounds seen =
          along > 0.0 ? two->position : between(-two->position.upper, -two->position.lower);
      if (std::abs(one->position.lower - seen.lower) > same_limit ||
          std::abs(one->position.upper - seen.upper) > same_limit)
        differ(3, fmt::format("joint \"{}\" has {} and \"{}\", seen in the mirror, {}", one->joint,
                              text_of(one->position), two->joint, text_of(seen)));
      if (unlike(one->effort, two->effort) > same_effort)
        differ(4, fmt::format("joint \"{}\" has {:.4g} Nm and \"{}\" {:.4g} Nm", one->joint,
                              one->effort, two->joint, two->effort));
    }
    constexpr std::array<std::array<const char*, 2>, 5> words{{{"masses", "<mass>"},
                                                               {"centres of mass", "<inertial>"},
                                                               {"axes", "<axis>"},
                                                               {"ranges", "<limit>"},
                                                               {"efforts", "<limit>"}}};
    for (std::size_t k = 0; k < kinds.size(); ++k)
      if (kinds[k].second > 0)
        sides.note(fmt::format(
            "different {} on the left and right: {}{}; correct the {} that is wrong", words[k][0],
            kinds[k].first,
            kinds[k].second > 1 ? fmt::format(", and {} more pairs", kinds[k].second - 1) : "",
            words[k][1]));
    if (legs_[0].has_knee() && legs_[1].has_knee()) {
      const Vec<double, 2> left = leg_lengths(model_, legs_[0]);
      const Vec<double, 2> right = leg_lengths(model_, legs_[1]);
      for (const int part : {0, 1}) {
        if (std::abs(left[part] - right[part]) <= same_length) continue;
        const auto joint = [&](const Leg& leg) {
          return model_.links()[static_cast<std::size_t>(part == 0 ? leg.knee : leg.ankle)]
              .joint.name;
        };
        sides.note(fmt::format(
            "the left {0} is {1:.1f} mm long and the right one {2:.1f} mm; correct the <origin> of "
            "\"{3}\" or \"{4}\"",
            part == 0 ? "thigh" : "shin", millimetres * left[part], millimetres * right[part],
            joint(legs_[0]), joint(legs_[1])));
      }
    }
    sides.good(fmt::format("{} pairs of joints are mirror images", all.size()));
  }

  // Length of the foot ahead of the ankle minus that behind it, divided by the whole length.
  double toes(robots::Side side) const {
    const Leg& leg = legs_[side == robots::Side::left ? 0 : 1];
    const Eigen::Isometry3d to_sole = poses_[static_cast<std::size_t>(leg.sole)].inverse();
    const double ankle = (to_sole * poses_[static_cast<std::size_t>(leg.ankle)].translation()).x();
    const Bounds& x = robot_.foot(side).x;
    return (x.upper + x.lower - 2.0 * ankle) / (x.upper - x.lower);
  }

  void knees() {
    Subject knees(findings_, "knees");
    constexpr double usable = 0.3;   // rad, least flexion of a knee
    constexpr double shorter = 0.1;  // fraction of a foot's length
    for (const robots::Side side : {robots::Side::left, robots::Side::right}) {
      const Leg& leg = legs_[side == robots::Side::left ? 0 : 1];
      if (!leg.has_knee()) {
        knees.note(
            fmt::format("not checked: no joint near the middle of the {} leg has an axis along y "
                        "of \"{}\"; check "
                        "the axes of the joints and of the sole",
                        name_of(side), robot_.sole(side)));
        continue;
      }
      const std::string& joint = model_.links()[static_cast<std::size_t>(leg.knee)].joint.name;
      if (!is_driven(joint)) {
        knees.note(fmt::format("\"{}\" is frozen; list it under joints in {}", joint, robot_.file));
        continue;
      }
      const Body& driven = body_.bodies[static_cast<std::size_t>(body_.joint_index(joint)) + 1];
      const Bounds range = leg.flexion(driven.position);
      const bool points_back = toes(side) < -shorter;
      const bool bends_back = range.upper < usable;
      if (points_back && (bends_back || -range.lower > range.upper))
        knees.wrong(fmt::format(
            "the {} toes point backwards and \"{}\" bends like a knee that faces backwards, so "
            "left and right are exchanged; correct the names of the joints, or turn x of \"{}\"",
            name_of(side), joint, robot_.sole(side)));
      else if (bends_back)
        knees.wrong(fmt::format(
            "\"{}\" bends the shin backwards by at most {:.2f} rad and forwards by {:.2f} rad, the "
            "wrong way for a knee; correct its <axis> or its <limit>",
            joint, std::max(range.upper, 0.0), -range.lower));
      else if (-range.lower > range.upper)
        knees.note(
            fmt::format("\"{}\" bends the shin forwards by {:.2f} rad and backwards by only {:.2f} "
                        "rad; check its <axis> and its <limit>",
                        joint, -range.lower, range.upper));
      else if (points_back)
        knees.note(fmt::format(
            "the {} foot is longer behind the ankle than ahead of it, so the forward direction is "
            "doubtful; check that x of \"{}\" points to the toes",
            name_of(side), robot_.sole(side)));
      for (const robots::StandingPosture& p : robot_.postures) posture(p, side, leg, joint, knees);
    }
    knees.good(fmt::format("bend by {:.2f} to {:.2f} rad in the postures, ahead of hip and ankle",
                           std::max(least_flexion_, 0.0), std::max(most_flexion_, 0.0)));
  }

  void posture(const robots::StandingPosture& p, robots::Side side, const Leg& leg,
               const std::string& joint, Subject& knees) {
    constexpr double straight = -0.05;  // rad, tolerance of a straight leg
    const auto found = p.joints.find(joint);
    const double flexion = leg.flexion(found == p.joints.end() ? 0.0 : found->second);
    least_flexion_ = std::min(least_flexion_, flexion);
    most_flexion_ = std::max(most_flexion_, flexion);
    if (flexion >= straight) return;
    const std::string text = fmt::format(
        "in \"{}\" the knee \"{}\" is {:.0f} mm behind the line from hip to ankle, so it bends the "
        "wrong way; change the joints of the posture in {}",
        p.name, joint, -millimetres * knee_ahead(model_, leg, p.joints), robot_.file);
    if (p.stance == robots::Stance::both || p.side() == side)
      knees.wrong(text);
    else
      knees.note(text);
  }

  const robots::UrdfModel& model_;
  const robots::RobotDescription& robot_;
  const robots::FloatingRobot& body_;
  std::vector<Finding>& findings_;
  std::vector<Eigen::Isometry3d> poses_;
  std::array<Leg, 2> legs_;  // left, right
  double least_flexion_ = infinity, most_flexion_ = -infinity;
};

}  // namespace

void check_plausibility(const robots::UrdfModel& model, const robots::RobotDescription& robot,
                        const robots::FloatingRobot& body, std::vector<Finding>& findings) {
  Plausibility(model, robot, body, findings).run();
}

}  // namespace saltus::survey
