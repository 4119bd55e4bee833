#include "saltus/robots/model/robot_description.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <limits>

#include "saltus/core/error.hpp"
#include "saltus/core/text.hpp"
#include "saltus/robots/model/mesh.hpp"
#include "saltus/yaml/yaml_section.hpp"

namespace saltus::robots {
namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

// True if the file contains this value. Only values from the URDF may be missing.
bool gives(const YamlSection& section, const std::string& key, RobotDescription::Figures figures) {
  if (!section.has(key) && figures == RobotDescription::Figures::in_file)
    section.fail(key, "is missing; add it, or name the URDF, from which it can be computed");
  return section.has(key);
}

FootRectangle read_foot(const YamlSection& section) {
  section.allow_only({"x", "y"});
  return {section.range("x"), section.range("y")};
}

RobotDescription::Mirror read_mirror(const YamlSection& section) {
  section.allow_only({"left", "right", "reversed"});
  return {section.text("left"), section.text("right"), section.texts("reversed")};
}

// Reads the mirror image of a posture that precedes it in the file.
StandingPosture read_mirrored_posture(const YamlSection& section, const RobotDescription& robot) {
  section.allow_only({"mirror_of"});
  const std::string original = section.text("mirror_of");
  if (!robot.mirror)
    section.fail("mirror_of", "needs the key mirror at the top of the file; add it");
  for (const StandingPosture& posture : robot.postures) {
    if (posture.name != original) continue;
    if (posture.stance == Stance::both)
      section.fail("mirror_of",
                   fmt::format("must name a posture on one foot, but \"{}\" is on both feet",
                               shortened(original)));
    return (*robot.mirror)(posture);
  }
  section.fail("mirror_of",
               fmt::format("must name a posture that precedes it in the file, not \"{}\"",
                           shortened(original)));
}

StandingPosture read_posture(const YamlSection& section, RobotDescription::Figures figures) {
  section.allow_only({"stance", "com", "other_foot", "joints"});
  StandingPosture posture;
  const std::string stance = section.text("stance");
  if (stance == "left")
    posture.stance = Stance::left;
  else if (stance == "right")
    posture.stance = Stance::right;
  else if (stance == "both")
    posture.stance = Stance::both;
  else
    section.fail("stance",
                 fmt::format("must be left, right or both, not \"{}\"", shortened(stance)));
  posture.com.setConstant(unknown);
  posture.other_foot.setConstant(unknown);
  if (gives(section, "com", figures)) {
    posture.com = section.numbers<3>("com");
    if (!(posture.com.z() > 0.0)) section.fail("com", "must be above the ground");
  }
  if (gives(section, "other_foot", figures)) posture.other_foot = section.numbers<3>("other_foot");
  const YamlSection joints = section.section("joints");
  for (const std::string& joint : joints.keys()) posture.joints[joint] = joints.number(joint);
  return posture;
}

RobotDescription::Joint read_joint(const YamlSection& section, const std::string& name) {
  section.allow_only({"position", "effort", "velocity", "rotor_inertia", "viscous_friction",
                      "dry_friction", "breakaway", "stall_torque", "no_load_speed", "stiffness",
                      "backlash"});
  RobotDescription::Joint joint{name, std::nullopt, std::nullopt, std::nullopt, {}};
  if (section.has("position")) joint.position = section.range("position");
  const auto read_positive = [&](const char* key, std::optional<double>& value) {
    if (!section.has(key)) return;
    value = section.number(key);
    if (!(*value > 0.0)) section.fail(key, "must be positive");
  };
  read_positive("effort", joint.effort);
  read_positive("velocity", joint.velocity);
  const auto read_at_least = [&](double least, const char* key, double& value) {
    if (!section.has(key)) return;
    value = section.number(key);
    if (!(value >= least)) section.fail(key, fmt::format("must be at least {}", least));
  };
  read_at_least(0.0, "rotor_inertia", joint.drive.rotor_inertia);
  read_at_least(0.0, "viscous_friction", joint.drive.viscous_friction);
  read_at_least(0.0, "dry_friction", joint.drive.dry_friction);
  read_at_least(1.0, "breakaway", joint.drive.breakaway);
  std::optional<double> stall_torque, no_load_speed;
  read_positive("stall_torque", stall_torque);
  read_positive("no_load_speed", no_load_speed);
  joint.drive.stall_torque = stall_torque.value_or(infinity);
  joint.drive.no_load_speed = no_load_speed.value_or(infinity);
  std::optional<double> stiffness;
  read_positive("stiffness", stiffness);
  joint.drive.stiffness = stiffness.value_or(infinity);
  read_at_least(0.0, "backlash", joint.drive.backlash);
  if (stiffness && joint.drive.rotor_inertia == 0.0)
    section.fail("stiffness", "needs a rotor that turns the spring; add rotor_inertia");
  if (joint.drive.backlash > 0.0 && !stiffness)
    section.fail("backlash", "needs a spring at its ends; add stiffness");
  return joint;
}

// Each entry gives the two ends, then the radius.
std::vector<RobotDescription::LinkCapsule> read_capsules(const YamlSection& links) {
  std::vector<RobotDescription::LinkCapsule> capsules;
  for (const std::string& link : links.keys()) {
    const YamlSection of_link = links.section(link);
    for (const std::string& number : of_link.keys()) {
      const Vec<double, 7> c = of_link.numbers<7>(number);
      if (!(c[6] > 0.0)) of_link.fail(number, "must end with a positive radius");
      capsules.push_back({link, {c.head<3>(), c.segment<3>(3), c[6]}});
    }
  }
  return capsules;
}

RobotDescription read(const YamlEntry& root, const std::string& source,
                      RobotDescription::Figures figures) {
  if (root.entries.empty())
    throw InputError(source + ": the file is empty; give a robot's configuration file");
  const YamlSection file(root, source);
  file.allow_only({"name", "source", "mass", "soles", "contact_plane_offset", "left_foot",
                   "right_foot", "base", "joints", "foot_sensor_range", "capsules", "mirror",
                   "postures"});
  RobotDescription robot;
  robot.name = file.text("name");
  robot.file = source;
  robot.source = fmt::format("{} ({})", source, file.text("source"));
  robot.mass = gives(file, "mass", figures) ? file.number("mass") : unknown;
  if (robot.mass <= 0.0) file.fail("mass", fmt::format("must be positive, not {} kg", robot.mass));
  const YamlSection soles = file.section("soles");
  soles.allow_only({"left", "right"});
  robot.left_sole = soles.text("left");
  robot.right_sole = soles.text("right");
  if (robot.left_sole == robot.right_sole)
    soles.fail("right",
               fmt::format("names the link of the left sole, \"{}\"; name the other foot's",
                           shortened(robot.left_sole)));
  const auto foot = [&](const std::string& key) {
    return gives(file, key, figures) ? read_foot(file.section(key))
                                     : FootRectangle{exactly(unknown), exactly(unknown)};
  };
  robot.contact_plane_offset =
      gives(file, "contact_plane_offset", figures) ? file.number("contact_plane_offset") : unknown;
  robot.left_foot = foot("left_foot");
  robot.right_foot = foot("right_foot");
  if (file.has("base")) robot.base = file.text("base");
  if (file.has("joints")) {
    const YamlSection joints = file.section("joints");
    for (const std::string& name : joints.keys())
      robot.joints.push_back(read_joint(joints.section(name), name));
  }
  if (file.has("foot_sensor_range")) {
    robot.foot_sensor_range = file.numbers<6>("foot_sensor_range");
    if (!(robot.foot_sensor_range->minCoeff() > 0.0))
      file.fail("foot_sensor_range", "must have six positive numbers");
  }
  if (file.has("capsules")) robot.capsules = read_capsules(file.section("capsules"));
  if (file.has("mirror")) robot.mirror = read_mirror(file.section("mirror"));
  const YamlSection postures = file.section("postures");
  for (const std::string& name : postures.keys()) {
    const YamlSection section = postures.section(name);
    robot.postures.push_back(section.has("mirror_of") ? read_mirrored_posture(section, robot)
                                                      : read_posture(section, figures));
    robot.postures.back().name = name;
  }
  if (robot.postures.empty()) file.fail("postures", "has no posture; add one");
  return robot;
}

// Uses the collision boxes. Without them, the rectangle comes from the file, and the contact plane
// from the shapes of the foot.
UrdfModel::Foot foot_of(const UrdfModel& model, const RobotDescription& named, Side side) {
  if (model.has_collision_box(named.sole(side))) return model.foot(named.sole(side));
  UrdfModel::Foot foot{named.foot(side), named.contact_plane_offset};
  if (const auto plane = lowest_point(model, named.sole(side))) foot.contact_plane_offset = *plane;
  const auto refuse = [&](const std::string& key) {
    throw InputError(
        fmt::format("{}: {} is missing; add it, or a <collision> with a <box> to the foot "
                    "of \"{}\" in {}",
                    named.file, key, shortened(named.sole(side)), model.source()));
  };
  if (!std::isfinite(foot.rectangle.x.lower)) refuse(fmt::format("{}_foot", name_of(side)));
  if (!std::isfinite(foot.contact_plane_offset)) refuse("contact_plane_offset");
  return foot;
}

}  // namespace

std::string RobotDescription::Mirror::namesake(const std::string& joint) const {
  // letters of the shortest word that is unlikely to be part of another word
  constexpr std::size_t telling = 3;
  std::string mirrored = joint;
  if (mirrored.starts_with(left)) return mirrored.replace(0, left.size(), right);
  if (mirrored.starts_with(right)) return mirrored.replace(0, right.size(), left);
  // A short word that begins with a separator, such as "_l", also counts at the end.
  if (!left.empty() && std::isalnum(static_cast<unsigned char>(left.front())) == 0) {
    if (mirrored.ends_with(left))
      return mirrored.replace(mirrored.size() - left.size(), left.size(), right);
    if (mirrored.ends_with(right))
      return mirrored.replace(mirrored.size() - right.size(), right.size(), left);
  }
  if (std::min(left.size(), right.size()) < telling) return mirrored;
  if (const auto at = mirrored.find(left); at != std::string::npos)
    return mirrored.replace(at, left.size(), right);
  if (const auto at = mirrored.find(right); at != std::string::npos)
    return mirrored.replace(at, right.size(), left);
  return mirrored;
}

StandingPosture RobotDescription::Mirror::operator()(const StandingPosture& posture) const {
  const Vec<double, 3> image(1.0, -1.0, 1.0);
  StandingPosture result = posture;
  if (posture.stance != Stance::both)
    result.stance = posture.stance == Stance::left ? Stance::right : Stance::left;
  result.com = image.cwiseProduct(posture.com);
  result.other_foot = image.cwiseProduct(posture.other_foot);
  result.joints.clear();
  for (const auto& [joint, position] : posture.joints) {
    const bool changes = std::find(reversed.begin(), reversed.end(), joint) != reversed.end();
    result.joints[namesake(joint)] = changes ? -position : position;
  }
  return result;
}

const StandingPosture& RobotDescription::posture_on(Side side) const {
  const Stance wanted = side == Side::left ? Stance::left : Stance::right;
  for (const StandingPosture& p : postures)
    if (p.stance == wanted) return p;
  const char* foot = name_of(side);
  throw InputError(
      fmt::format("{} has no posture on the {} foot alone; add one with stance: {} to its file",
                  name, foot, foot));
}

const StandingPosture& RobotDescription::default_posture() const {
  if (postures.empty())
    throw DefinitionError(
        fmt::format("robot '{}' has no postures, so it has no default posture", name));
  return postures.front();
}

const StandingPosture& RobotDescription::posture(const std::string& posture_name) const {
  std::vector<std::string> known;
  for (const StandingPosture& p : postures) {
    if (p.name == posture_name) return p;
    known.push_back(p.name);
  }
  const std::string nearest = nearest_name(posture_name, known);
  throw InputError(fmt::format("{} has no posture \"{}\"; {}", name, shortened(posture_name),
                               nearest.empty() ? "the known postures are " + join_names(known)
                                               : fmt::format("did you mean \"{}\"?", nearest)));
}

RobotDescription parse_robot_description(const std::string& text, const std::string& source,
                                         RobotDescription::Figures figures) {
  return read(parse_yaml(text, source), source, figures);
}

RobotDescription read_robot_description(const std::filesystem::path& file,
                                        RobotDescription::Figures figures) {
  return read(read_yaml(file), file.string(), figures);
}

RobotDescription describe(const UrdfModel& model, const RobotDescription& named) {
  RobotDescription robot = named;
  robot.source = fmt::format("{} (URDF; postures of {})", model.source(), named.name);
  robot.mass = model.total_mass();
  const UrdfModel::Foot left = foot_of(model, named, Side::left);
  const UrdfModel::Foot right = foot_of(model, named, Side::right);
  if (!model.has_collision_box(named.left_sole) || !model.has_collision_box(named.right_sole))
    robot.warnings.push_back(
        fmt::format("{}: the feet have no collision box, so thin boxes with the rectangles of {} "
                    "are used; add a <collision> with a <box> to their links",
                    model.source(), named.file));
  constexpr double unlike = 1e-3;  // m
  if (std::abs(left.contact_plane_offset - named.contact_plane_offset) > unlike)
    robot.warnings.push_back(
        fmt::format("{}: the feet touch the ground {:.1f} mm along z of \"{}\", not {:.1f} mm as "
                    "{} says; the value of the URDF is used",
                    model.source(), 1e3 * left.contact_plane_offset, named.left_sole,
                    1e3 * named.contact_plane_offset, named.file));
  constexpr double same = 1e-6;  // m
  if (std::abs(left.contact_plane_offset - right.contact_plane_offset) > same)
    throw InputError(
        fmt::format("{}: the contact plane is at {:.6f} m in \"{}\" but at {:.6f} m in \"{}\"; "
                    "make the collision boxes of both feet equal",
                    model.source(), left.contact_plane_offset, shortened(named.left_sole),
                    right.contact_plane_offset, shortened(named.right_sole)));
  robot.contact_plane_offset = left.contact_plane_offset;
  robot.left_foot = left.rectangle;
  robot.right_foot = right.rectangle;
  const Vec<double, 3> to_contact(0.0, 0.0, robot.contact_plane_offset);
  for (StandingPosture& posture : robot.postures) {
    const std::string& sole = named.sole(posture.side());
    const std::string& other_sole = named.sole(other(posture.side()));
    posture.com = model.centre_of_mass(sole, posture.joints) - to_contact;
    posture.other_foot =
        model.link_pose(other_sole, sole, posture.joints) * to_contact - to_contact;
  }
  return robot;
}

}  // namespace saltus::robots
