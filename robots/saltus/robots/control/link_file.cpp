#include "saltus/robots/control/link_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string_view>
#include <utility>

#include "saltus/core/error.hpp"
#include "saltus/yaml/yaml_section.hpp"

namespace saltus::robots::control {
namespace {

// A number of the robot file and the field that it sets.
struct Key {
  const char* section;  // empty: directly in the file
  const char* name;
  double* field;
  bool may_be_zero;
  const char* meaning;
};
std::vector<Key> keys_of(ControlOptions& o) {
  return {
      {"", "period", &o.period, false, "period of the readings, s"},
      {"gains", "stiffness", &o.stiffness, true,
       "stiffness in stand and in the soft stop, largest torques per rad"},
      {"gains", "damping", &o.damping, true,
       "damping in stand and in the soft stop, largest torques per rad/s"},
      {"filters", "inertial_hz", &o.inertial_hz, true,
       "bandwidth for gyroscope and accelerometer, Hz; 0: no filter"},
      {"filters", "force_hz", &o.force_hz, true,
       "bandwidth for the wrenches of the feet, Hz; 0: no filter"},
      {"filters", "velocity_hz", &o.velocity_hz, true,
       "bandwidth for joint velocities, Hz; 0: no filter"},
      {"filters", "torque_hz", &o.torque_hz, true,
       "bandwidth for commanded torques, Hz; 0: no filter"},
      {"guards", "near", &o.near, false, "largest joint error at which stand ends, rad"},
      {"guards", "beyond_limit", &o.beyond_limit, true,
       "largest violation of the limits of a joint, rad"},
      {"guards", "speed_factor", &o.speed_factor, false,
       "largest speed of a joint, as a multiple of its limit"},
      {"guards", "clock_error", &o.clock_error, false,
       "largest relative error of the period in the time stamps"},
      {"guards", "stuck_time", &o.stuck.time, true,
       "time without motion after which a driven joint is stuck, s; 0: never"},
      {"guards", "stuck_motion", &o.stuck.motion, false, "smallest motion, rad"},
      {"guards", "stuck_change", &o.stuck.change, false,
       "change of the torque that must move a joint, as a fraction of the largest torque"},
      {"guards", "stuck_limit", &o.stuck.limit, false,
       "constant torque that must move a joint, as a fraction of the largest torque"},
  };
}

void read_joint(const YamlSection& section, LinkJoint& joint) {
  section.allow_only({"torque", "speed", "limits", "start", "gain"});
  if (section.has("torque")) joint.effort = section.number("torque");
  if (section.has("speed")) joint.speed = section.number("speed");
  if (section.has("limits")) joint.position = section.range("limits");
  if (section.has("start")) joint.start = section.number("start");
  if (section.has("gain")) joint.gain = section.number("gain");
  if (!(joint.effort > 0.0)) section.fail("torque", "must be the largest torque, above 0");
  if (!(joint.speed > 0.0)) section.fail("speed", "must be above 0");
  if (!(joint.gain >= 0.0)) section.fail("gain", "must be at least 0");
  if (joint.start < joint.position.lower || joint.start > joint.position.upper)
    section.fail("start", "must be within the limits");
}

}  // namespace

void read_link_file(const std::filesystem::path& file, std::vector<LinkJoint>& joints,
                    ControlOptions& options) {
  const YamlEntry root = read_yaml(file);
  const YamlSection top(root, file.string());
  top.allow_only({"period", "joints", "gains", "filters", "guards"});
  const bool is_complete = joints.empty();
  std::vector<LinkJoint> all = joints;
  if (is_complete && !top.has("joints"))
    top.fail("joints", "must list the joints of the robot, in the order of its messages");
  if (top.has("joints")) {
    const YamlSection list = top.section("joints");
    for (const std::string& name : list.keys()) {
      auto joint = std::ranges::find(all, name, &LinkJoint::name);
      if (joint == all.end()) {
        if (!is_complete) list.fail(name, "is not a joint of this robot");
        joint = all.insert(all.end(), LinkJoint{.name = name});
      }
      read_joint(list.section(name), *joint);
    }
  }
  ControlOptions read = options;
  const std::vector<Key> keys = keys_of(read);
  for (const char* name : {"gains", "filters", "guards"}) {
    if (!top.has(name)) continue;
    std::vector<std::string> known;
    for (const Key& key : keys)
      if (std::string_view(key.section) == name) known.emplace_back(key.name);
    top.section(name).allow_only(known);
  }
  for (const Key& key : keys) {
    const bool is_top = *key.section == '\0';
    if (!is_top && !top.has(key.section)) continue;
    const YamlSection section = is_top ? top : top.section(key.section);
    if (!section.has(key.name)) continue;
    const double value = section.number(key.name);
    if (value < 0.0 || (value == 0.0 && !key.may_be_zero))
      section.fail(key.name, key.may_be_zero ? "must be at least 0" : "must be above 0");
    *key.field = value;
  }
  joints = std::move(all);
  options = read;
}

std::string to_link_file(const std::vector<LinkJoint>& joints, const ControlOptions& options) {
  std::string text =
      "# Joints, gains, filters and guards of a robot behind `saltus control --robot FILE`.\n";
  const char* section = "";
  ControlOptions values = options;
  for (const Key& key : keys_of(values)) {
    if (std::string_view(section) != key.section) text += fmt::format("{}:\n", key.section);
    section = key.section;
    text += fmt::format("{}{}: {}  # {}\n", *section != '\0' ? "  " : "", key.name, *key.field,
                        key.meaning);
  }
  text += "joints:  # in the order of the messages; speed, limits, start and gain are optional\n";
  for (const LinkJoint& joint : joints) {
    text += fmt::format("  {}:\n    torque: {}  # largest\n", joint.name, joint.effort);
    if (joint.speed < infinity) text += fmt::format("    speed: {}\n", joint.speed);
    if (joint.position.lower > -infinity && joint.position.upper < infinity)
      text += fmt::format("    limits: [{}, {}]\n", joint.position.lower, joint.position.upper);
    text += fmt::format("    start: {}\n    gain: {}  # factor of the springs and dampers\n",
                        joint.start, joint.gain);
  }
  return text;
}

}  // namespace saltus::robots::control
