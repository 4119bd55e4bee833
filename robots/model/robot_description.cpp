#include "saltus/robots/model/robot_description.hpp"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <iterator>
#include <limits>

#include "saltus/core/text.hpp"

namespace saltus {
namespace {

// A mapping of the file with the way to it, for messages: "file: postures.left_stance.com".
class Section {
 public:
  Section(const YAML::Node& node, std::string source, std::string path)
      : node_(node), source_(std::move(source)), path_(std::move(path)) {
    if (!node_.IsMap()) fail("", "must be a set of keys with values");
    for (const auto& entry : node_) {
      const std::string key = entry.first.as<std::string>();
      if (has(key)) fail(key, "stands twice; keep one");
      keys_.push_back(key);
    }
  }

  const std::vector<std::string>& keys() const { return keys_; }
  bool has(const std::string& key) const {
    return std::find(keys_.begin(), keys_.end(), key) != keys_.end();
  }

  void allow_only(const std::vector<std::string>& known) const {
    for (const std::string& key : keys_) {
      if (std::find(known.begin(), known.end(), key) != known.end()) continue;
      const std::string nearest = nearest_name(key, known);
      fail(key, nearest.empty() ? "is not a known key; known are " + join_names(known)
                                : fmt::format("is not a known key; did you mean \"{}\"?", nearest));
    }
  }

  // Whether a figure is here to be read. It may be missing where the URDF gives it.
  bool gives(const std::string& key, Figures figures) const {
    if (!has(key) && figures == Figures::in_file)
      fail(key, "is missing; add it, or name the URDF, from which it can be computed");
    return has(key);
  }

  Section section(const std::string& key) const { return {require(key), source_, way_to(key)}; }

  std::string text(const std::string& key) const {
    const YAML::Node node = require(key);
    if (!node.IsScalar() || node.Scalar().empty()) fail(key, "must be a text");
    return node.Scalar();
  }

  double number(const std::string& key) const { return number(require(key), key); }

  template <int n>
  Vec<double, n> numbers(const std::string& key) const {
    const YAML::Node node = require(key);
    if (!node.IsSequence() || node.size() != n)
      fail(key, fmt::format("must be a list of {} numbers", n));
    Vec<double, n> values;
    for (int i = 0; i < n; ++i) values[i] = number(node[i], key);
    return values;
  }

  std::vector<std::string> texts(const std::string& key) const {
    const YAML::Node node = require(key);
    if (!node.IsSequence()) fail(key, "must be a list of texts");
    std::vector<std::string> values;
    for (const YAML::Node& entry : node) {
      if (!entry.IsScalar() || entry.Scalar().empty()) fail(key, "must be a list of texts");
      values.push_back(entry.Scalar());
    }
    return values;
  }

  Bounds range(const std::string& key) const {
    const Vec<double, 2> ends = numbers<2>(key);
    if (!(ends[0] < ends[1]))
      fail(key, fmt::format("is empty, from {} to {}; give the smaller first", ends[0], ends[1]));
    return between(ends[0], ends[1]);
  }

  [[noreturn]] void fail(const std::string& key, const std::string& what) const {
    const std::string way = key.empty() ? path_ : way_to(key);
    throw InputError(fmt::format("{}: {} {}", source_, way.empty() ? "the file" : way, what));
  }

 private:
  std::string way_to(const std::string& key) const {
    return path_.empty() ? key : path_ + "." + key;
  }
  YAML::Node require(const std::string& key) const {
    if (!has(key)) fail(key, "is missing; add it");
    return node_[key];
  }
  double number(const YAML::Node& node, const std::string& key) const {
    double value = 0.0;
    if (!node.IsScalar() || !YAML::convert<double>::decode(node, value))
      fail(key, fmt::format("must be a number{}",
                            node.IsScalar() ? ", not \"" + node.Scalar() + "\"" : ""));
    if (!std::isfinite(value)) fail(key, fmt::format("must be finite, not {}", value));
    return value;
  }

  YAML::Node node_;
  std::string source_, path_;
  std::vector<std::string> keys_;
};

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

FootRectangle read_foot(const Section& section) {
  section.allow_only({"x", "y"});
  return {section.range("x"), section.range("y")};
}

Mirror read_mirror(const Section& section) {
  section.allow_only({"left", "right", "reversed"});
  return {section.text("left"), section.text("right"), section.texts("reversed")};
}

// The mirror image of a posture that stands above it in the file.
StandingPosture read_mirrored_posture(const Section& section, const RobotDescription& robot) {
  section.allow_only({"mirror_of"});
  const std::string original = section.text("mirror_of");
  if (!robot.mirror)
    section.fail("mirror_of", "needs the key mirror at the top of the file; add it");
  for (const StandingPosture& posture : robot.postures) {
    if (posture.name != original) continue;
    if (posture.stance == Stance::both)
      section.fail("mirror_of",
                   fmt::format("must name a posture on one foot; \"{}\" stands on both", original));
    return (*robot.mirror)(posture);
  }
  section.fail("mirror_of", fmt::format("must name a posture above, not \"{}\"", original));
}

StandingPosture read_posture(const Section& section, Figures figures) {
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
    section.fail("stance", fmt::format("must be left, right or both, not \"{}\"", stance));
  posture.com.setConstant(unknown);
  posture.other_foot.setConstant(unknown);
  if (section.gives("com", figures)) {
    posture.com = section.numbers<3>("com");
    if (!(posture.com.z() > 0.0)) section.fail("com", "must lie above the ground");
  }
  if (section.gives("other_foot", figures)) posture.other_foot = section.numbers<3>("other_foot");
  const Section joints = section.section("joints");
  for (const std::string& joint : joints.keys()) posture.joints[joint] = joints.number(joint);
  return posture;
}

ActuatedJoint read_joint(const Section& section, const std::string& name) {
  section.allow_only({"position", "effort"});
  ActuatedJoint joint{name, std::nullopt, std::nullopt};
  if (section.has("position")) joint.position = section.range("position");
  if (section.has("effort")) {
    joint.effort = section.number("effort");
    if (!(*joint.effort > 0.0)) section.fail("effort", "must be positive");
  }
  return joint;
}

RobotDescription read(const Section& file, Figures figures) {
  file.allow_only({"name", "source", "mass", "soles", "contact_plane_offset", "left_foot",
                   "right_foot", "base", "joints", "mirror", "postures"});
  RobotDescription robot;
  robot.name = file.text("name");
  robot.mass = file.gives("mass", figures) ? file.number("mass") : unknown;
  if (robot.mass <= 0.0) file.fail("mass", fmt::format("must be positive, not {} kg", robot.mass));
  const Section soles = file.section("soles");
  soles.allow_only({"left", "right"});
  robot.left_sole = soles.text("left");
  robot.right_sole = soles.text("right");
  const auto foot = [&](const std::string& key) {
    return file.gives(key, figures) ? read_foot(file.section(key))
                                    : FootRectangle{exactly(unknown), exactly(unknown)};
  };
  robot.contact_plane_offset =
      file.gives("contact_plane_offset", figures) ? file.number("contact_plane_offset") : unknown;
  robot.left_foot = foot("left_foot");
  robot.right_foot = foot("right_foot");
  if (file.has("base")) robot.base = file.text("base");
  if (file.has("joints")) {
    const Section joints = file.section("joints");
    for (const std::string& name : joints.keys())
      robot.joints.push_back(read_joint(joints.section(name), name));
  }
  if (file.has("mirror")) robot.mirror = read_mirror(file.section("mirror"));
  const Section postures = file.section("postures");
  for (const std::string& name : postures.keys()) {
    const Section section = postures.section(name);
    robot.postures.push_back(section.has("mirror_of") ? read_mirrored_posture(section, robot)
                                                      : read_posture(section, figures));
    robot.postures.back().name = name;
  }
  if (robot.postures.empty()) file.fail("postures", "has no posture; add one");
  return robot;
}

// From the collision boxes, else from the file.
FootGeometry foot_of(const UrdfModel& model, const RobotDescription& named, Side side) {
  if (model.has_collision_box(named.sole(side))) return model.foot(named.sole(side));
  const FootGeometry foot{named.foot(side), named.contact_plane_offset};
  const auto refuse = [&](const std::string& key) {
    throw InputError(
        fmt::format("{}: {} is missing; add it, or a <collision> with a <box> to the foot "
                    "of \"{}\" in {}",
                    named.file, key, named.sole(side), model.source()));
  };
  if (!std::isfinite(foot.rectangle.x.lower)) refuse(fmt::format("{}_foot", name_of(side)));
  if (!std::isfinite(foot.contact_plane_offset)) refuse("contact_plane_offset");
  return foot;
}

}  // namespace

StandingPosture Mirror::operator()(const StandingPosture& posture) const {
  const Vec<double, 3> image(1.0, -1.0, 1.0);
  StandingPosture result = posture;
  if (posture.stance != Stance::both)
    result.stance = posture.stance == Stance::left ? Stance::right : Stance::left;
  result.com = image.cwiseProduct(posture.com);
  result.other_foot = image.cwiseProduct(posture.other_foot);
  result.joints.clear();
  for (const auto& [joint, position] : posture.joints) {
    const bool changes = std::find(reversed.begin(), reversed.end(), joint) != reversed.end();
    std::string namesake = joint;
    if (joint.compare(0, left.size(), left) == 0)
      namesake.replace(0, left.size(), right);
    else if (joint.compare(0, right.size(), right) == 0)
      namesake.replace(0, right.size(), left);
    result.joints[namesake] = changes ? -position : position;
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

const StandingPosture& RobotDescription::posture(const std::string& posture_name) const {
  std::vector<std::string> known;
  for (const StandingPosture& p : postures) {
    if (p.name == posture_name) return p;
    known.push_back(p.name);
  }
  const std::string nearest = nearest_name(posture_name, known);
  throw InputError(fmt::format("{} has no posture \"{}\"; {}", name, posture_name,
                               nearest.empty() ? "known are " + join_names(known)
                                               : fmt::format("did you mean \"{}\"?", nearest)));
}

RobotDescription parse_robot_description(const std::string& text, const std::string& source,
                                         Figures figures) {
  try {
    const YAML::Node node = YAML::Load(text);
    if (!node.IsDefined() || node.IsNull())
      throw InputError(
          fmt::format("{}: the file is empty; give a robot's configuration file", source));
    const Section file(node, source, "");
    RobotDescription robot = read(file, figures);
    robot.file = source;
    robot.source = fmt::format("{} ({})", source, file.text("source"));
    return robot;
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}: this is not well-formed YAML, line {}: {}", source,
                                 error.mark.line + 1, error.msg));
  }
}

RobotDescription read_robot_description(const std::filesystem::path& file, Figures figures) {
  std::error_code ignored;
  if (!std::filesystem::is_regular_file(file, ignored))
    throw InputError(
        fmt::format("{}: there is no such file, or it is a folder; give the path of a robot's "
                    "configuration file",
                    file.string()));
  std::ifstream stream(file, std::ios::binary);
  if (!stream)
    throw InputError(
        fmt::format("{}: the file cannot be read; check its permissions", file.string()));
  const std::string text{std::istreambuf_iterator<char>(stream), {}};
  return parse_robot_description(text, file.string(), figures);
}

RobotDescription describe(const UrdfModel& model, const RobotDescription& named) {
  RobotDescription robot = named;
  robot.source = fmt::format("{} (URDF; postures of {})", model.source(), named.name);
  robot.mass = model.total_mass();
  const FootGeometry left = foot_of(model, named, Side::left);
  const FootGeometry right = foot_of(model, named, Side::right);
  if (!model.has_collision_box(named.left_sole) || !model.has_collision_box(named.right_sole))
    robot.warnings.push_back(
        fmt::format("{}: the feet have no collision box and stand on thin ones, the rectangles of "
                    "{}; add a <collision> with a <box> to their links",
                    model.source(), named.file));
  constexpr double same = 1e-6;  // m
  if (std::abs(left.contact_plane_offset - right.contact_plane_offset) > same)
    throw InputError(fmt::format(
        "{}: the contact plane lies at {:.6f} m of \"{}\" but at {:.6f} m of \"{}\"; make the "
        "collision boxes of the feet alike",
        model.source(), left.contact_plane_offset, named.left_sole, right.contact_plane_offset,
        named.right_sole));
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

}  // namespace saltus
