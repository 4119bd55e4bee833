#include "problems/biped/survey/robot_file.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "problems/biped/survey/leg.hpp"
#include "problems/biped/survey/posture_search.hpp"
#include "saltus/core/text.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"

namespace saltus::survey {
namespace {

Vec<double, 2> centre(const robots::FootRectangle& foot) {
  return {0.5 * (foot.x.lower + foot.x.upper), 0.5 * (foot.y.lower + foot.y.upper)};
}

const robots::UrdfModel::Link& link_of(const robots::UrdfModel& model, const std::string& joint) {
  return *std::find_if(
      model.links().begin(), model.links().end(),
      [&](const robots::UrdfModel::Link& link) { return link.joint.name == joint; });
}

const robots::UrdfModel::Joint& joint_of(const robots::UrdfModel& model, int link) {
  return model.links()[static_cast<std::size_t>(link)].joint;
}

// Start of the search: legs bent so that the knees go forward and the soles stay level, arms
// slightly away from the body.
robots::Posture start_of(const robots::UrdfModel& model, const Limbs& limbs,
                         const std::vector<Leg>& legs) {
  constexpr double bent = 0.5, off = 0.2;  // rad
  constexpr double along = 0.9;            // least component of an axis along a coordinate axis
  const std::vector<Eigen::Isometry3d> poses = model.link_poses({});
  const auto axis = [&](int link) -> Vec<double, 3> {
    const auto index = static_cast<std::size_t>(link);
    return poses[index].linear() * model.links()[index].joint.axis;
  };
  robots::Posture start;
  for (const Leg& leg : legs) {
    if (!leg.has_knee()) continue;
    const double knee = leg.position(bent);
    start[joint_of(model, leg.knee).name] = knee;
    // Hip and ankle turn the other way, by half each. Their axes may be opposite to the knee's.
    for (const int link : {leg.hip, leg.ankle})
      start[joint_of(model, link).name] =
          axis(link).dot(axis(leg.knee)) > 0.0 ? -knee / 2.0 : knee / 2.0;
  }
  bool left_arm_done = false, right_arm_done = false;
  for (const std::string& name : limbs.joints) {
    if (std::find(limbs.legs.begin(), limbs.legs.end(), name) != limbs.legs.end()) continue;
    const int link = model.link_index(link_of(model, name).name);
    if (std::abs(axis(link).x()) < along || limbs.mirror.namesake(name) == name) continue;
    // The first joint of an arm that moves it sideways.
    const bool is_left = poses[static_cast<std::size_t>(link)].translation().y() > 0.0;
    bool& done = is_left ? left_arm_done : right_arm_done;
    if (!done) start[name] = (is_left ? off : -off) * (axis(link).x() > 0.0 ? 1.0 : -1.0);
    done = true;
  }
  return start;
}

// Restricts the knees of the search to the side on which humans bend them, if the limits allow it.
void bend_knees_forward(robots::FloatingRobot& body, const robots::UrdfModel& model,
                        const std::vector<Leg>& legs) {
  constexpr double least = 0.1, most = 0.3;  // rad, least flexion and the range that it requires
  for (const Leg& leg : legs) {
    if (!leg.has_knee()) continue;
    const int joint = body.joint_index(joint_of(model, leg.knee).name);
    Bounds& range = body.bodies[static_cast<std::size_t>(joint) + 1].position;
    if (leg.flexion(range).upper < most) continue;
    (leg.sign > 0.0 ? range.lower : range.upper) =
        leg.position(std::max(leg.flexion(range).lower, least));
  }
}

robots::StandingPosture posture_of(const robots::UrdfModel& model,
                                   const robots::FloatingRobot& body, const SurveyedRobot& robot,
                                   const robots::Posture& start, const char* name,
                                   robots::Stance stance) {
  const Limbs& limbs = robot.limbs;
  // Feet as far apart as with straight legs. The root link is lowered by this fraction of its
  // height.
  constexpr double lower = 0.04;
  constexpr double lift = 0.01;  // height of the swing foot, as a fraction of the same height
  const double height = -0.5 * (limbs.left.origin.z() + limbs.right.origin.z());
  PostureWish wish;
  wish.stance = stance == robots::Stance::right ? robots::Side::right : robots::Side::left;
  const double away = wish.stance == robots::Side::left ? -1.0 : 1.0;
  wish.trunk_height = (1.0 - lower) * height;
  // On both feet the legs must not twist to part limbs; the feet move apart instead.
  if (stance == robots::Stance::both) wish.rest_weight = 1.0;
  FoundPosture found;
  // Increase the distance if the shapes of the feet overlap.
  double apart = limbs.left.origin.y() - limbs.right.origin.y();
  constexpr int most_tries = 4;
  for (int k = 0; k < most_tries; ++k) {
    wish.other_foot = {0.0, away * apart, stance == robots::Stance::both ? 0.0 : lift * height};
    const Vec<double, 2> here = centre(robot.description.foot(wish.stance));
    const Vec<double, 2> there =
        centre(robot.description.foot(other(wish.stance))) + wish.other_foot.head<2>();
    wish.com = stance == robots::Stance::both ? Vec<double, 2>(0.5 * (here + there)) : here;
    found = find_posture(model, robot.description, body, wish, start);
    if (found.clearance >= 0.75 * wish.clearance) break;
    apart += wish.clearance - found.clearance;
  }
  if (!found.is_found())
    throw InputError(fmt::format(
        "{}: no posture on {} was found within the joints' limits: the nearest one misses the "
        "other foot's place by {:.1f} mm and {:.3f} rad and the CoM above the sole by {:.1f} mm; "
        "write a configuration file for the robot (robots/README.md)",
        model.source(), stance == robots::Stance::both ? "both feet" : "one foot",
        1e3 * found.foot_error, found.tilt, 1e3 * found.com_error));
  robots::StandingPosture posture;
  posture.name = name;
  posture.stance = stance;
  constexpr double rounding = 1e-6;  // rad, resolution of the file
  for (const auto& [joint, q] : found.joints)
    if (std::abs(q) > rounding) posture.joints[joint] = std::round(q / rounding) * rounding;
  return posture;
}

std::string range(const Bounds& b) { return fmt::format("[{:.6g}, {:.6g}]", b.lower, b.upper); }

std::string quoted(const std::string& text) {
  std::string safe = text;
  std::replace(safe.begin(), safe.end(), '"', '\'');
  std::replace(safe.begin(), safe.end(), '\\', '/');
  return '"' + safe + '"';
}

}  // namespace

SurveyedRobot survey_robot(const robots::UrdfModel& model) {
  SurveyedRobot robot;
  robot.limbs = find_limbs(model);
  robot.notes = robot.limbs.notes;
  const Limbs& limbs = robot.limbs;
  robots::RobotDescription& d = robot.description;
  d.name = model.name();
  d.source = fmt::format("data of {}", model.source());
  d.file = model.source();
  d.left_sole = limbs.left.sole;
  d.right_sole = limbs.right.sole;
  constexpr double same = 1e-4;  // m
  if (std::abs(limbs.left.contact_plane_offset - limbs.right.contact_plane_offset) > same)
    throw InputError(
        fmt::format("{}: the contact plane is at {:.4f} m in \"{}\" but at {:.4f} m in \"{}\"; "
                    "make the shapes of both feet equal",
                    model.source(), limbs.left.contact_plane_offset, d.left_sole,
                    limbs.right.contact_plane_offset, d.right_sole));
  d.contact_plane_offset =
      0.5 * (limbs.left.contact_plane_offset + limbs.right.contact_plane_offset);
  d.left_foot = limbs.left.rectangle;
  d.right_foot = limbs.right.rectangle;
  d.mirror = limbs.mirror;
  d.base = model.links().front().name;
  for (const std::string& joint : limbs.joints) d.joints.emplace_back().name = joint;
  robots::FloatingRobot body = robots::floating_robot(model, d);
  robots::add_capsules(body, model, d);
  const std::vector<Leg> legs{find_leg(model, d.left_sole), find_leg(model, d.right_sole)};
  bend_knees_forward(body, model, legs);
  const robots::Posture start = start_of(model, limbs, legs);
  d.postures.push_back(posture_of(model, body, robot, start, "left_stance", robots::Stance::left));
  d.postures.push_back(
      posture_of(model, body, robot, start, "right_stance", robots::Stance::right));
  d.postures.push_back(posture_of(model, body, robot, start, "two_feet", robots::Stance::both));
  d = describe(model, d);
  return robot;
}

std::string to_yaml(const SurveyedRobot& robot, const robots::UrdfModel& model) {
  const robots::RobotDescription& d = robot.description;
  std::string text = fmt::format(
      "# {}, written by `saltus robot new` from\n# {}\n# Keys: robots/README.md of Saltus.\n",
      printable(d.name), printable(model.source()));
  for (const std::string& note : robot.notes) text += fmt::format("# {}\n", printable(note));
  text +=
      fmt::format("name: {}\nsource: {}\n\n", quoted(d.name),
                  quoted("read from " + std::filesystem::path(model.source()).filename().string()));
  text += fmt::format("mass: {:.9g}  # kg\n", d.mass);
  text +=
      fmt::format("soles: {{left: {}, right: {}}}\n", quoted(d.left_sole), quoted(d.right_sole));
  text += fmt::format("contact_plane_offset: {:.6g}  # m, along z of the soles\n",
                      d.contact_plane_offset);
  for (const robots::Side side : {robots::Side::left, robots::Side::right})
    text += fmt::format("{}_foot: {{x: {}, y: {}}}  # m\n", name_of(side), range(d.foot(side).x),
                        range(d.foot(side).y));
  text += fmt::format("\nbase: {}\njoints:\n", quoted(d.base));
  for (const robots::RobotDescription::Joint& joint : d.joints)
    text += fmt::format("  {}: {{}}\n", quoted(joint.name));
  std::vector<std::string> reversed;
  for (const std::string& joint : d.mirror->reversed) reversed.push_back(quoted(joint));
  text += fmt::format("\nmirror: {{left: {}, right: {}, reversed: [{}]}}\n", quoted(d.mirror->left),
                      quoted(d.mirror->right), fmt::join(reversed, ", "));
  text += "\npostures:  # m in the contact frame of the stance foot; rad\n";
  for (const robots::StandingPosture& p : d.postures) {
    const char* stance = p.stance == robots::Stance::left    ? "left"
                         : p.stance == robots::Stance::right ? "right"
                                                             : "both";
    text += fmt::format(
        "  {}:\n    stance: {}\n    com: [{:.6g}, {:.6g}, {:.6g}]\n    other_foot: [{:.6g}, "
        "{:.6g}, "
        "{:.6g}]\n    joints:\n",
        p.name, stance, p.com.x(), p.com.y(), p.com.z(), p.other_foot.x(), p.other_foot.y(),
        p.other_foot.z());
    for (const auto& [joint, q] : p.joints)
      text += fmt::format("      {}: {:.6f}\n", quoted(joint), q);
  }
  return text;
}

}  // namespace saltus::survey
