#include "problems/push_recovery/config.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "problems/biped/keys/keys.hpp"
#include "saltus/app/settings.hpp"
#include "saltus/core/error.hpp"

namespace saltus::push_recovery {
namespace {

void declare_weights(Settings& s, Weights& w) {
  s.vector("weights.gamma", w.gamma, "",
           "weights of CoM, CoM velocity and angular momentum, at all times", at_least(0.0));
  s.vector(
      "weights.gamma_impact", w.gamma_impact, "",
      "additional weights of the same quantities after the impact and at the end of the horizon",
      at_least(0.0));
  s.vector("weights.wrench", w.wrench, "", "weights of force (N) and torque (Nm) of each foot",
           at_least(0.0));
  s.vector("weights.capture_point", w.capture_point, "",
           "weights of the capture point after the impact", at_least(0.0));
  s.vector("weights.capture_point_standing", w.capture_point_standing, "",
           "weights of the capture point while no step is planned", at_least(0.0));
  s.number("weights.wrench_change", w.wrench_change, "",
           "weight of the first differences of the wrenches", at_least(0.0));
  s.number("weights.capture_point_softness", w.capture_point_penalty, "1/(m s)",
           "penalty on a capture point outside the hull; 0: a hard constraint", at_least(0.0));
}

void declare_momentum(Settings& s, Config& config) {
  s.number("mpc.capturing_momentum", config.capturing_momentum, "",
           "desired angular momentum while the capture point would come to rest off the support, "
           "as a multiple of the one that stops it there; 0: none",
           between(0.0, 5.0));
}

// Presets for the fidelity of the simulation. Both set the same keys.
void declare_presets(Settings& s, Config& config) {
  const std::vector<std::string> of_formula{"step.shortest_s=0.3", "whole_body.tipped_reserve=0"};
  // The planner by optimal control rarely needs short steps. Its plans load the corners of the
  // stance sole, so the sole would tip without a reserve.
  const std::vector<std::string> of_ocp{"step.shortest_s=0.25", "whole_body.tipped_reserve=10"};
  const auto list = [](std::vector<std::string> values, const std::vector<std::string>& more) {
    values.insert(values.end(), more.begin(), more.end());
    return values;
  };
  const std::vector<std::string> paper =
      list({"step.duration=0.6", "step.planner=push_formula", "step.decide=always",
            "step.decision_lead_s=none", "sensors=ideal", "self_collision=false",
            "joint_speed_limits=false", "whole_body.stance_damping=50",
            "contact.friction=0.3333333333333333", "contact.corners=false", "dart.friction=box"},
           of_formula);
  std::vector<std::string> robot{
      "step.duration=0.5",  // about 0.56 s from the push
      "step.decide=if_it_helps", "step.decision_lead_s=0.1", "sensors=measured",
      "self_collision=true", "joint_speed_limits=true", "whole_body.stance_damping=30",
      // A foot that has just landed carries little load and tips more easily.
      "contact.friction=0.25", "contact.corners=true", "dart.friction=inscribed"};
  // A survival map over step times needs a planner that accepts them.
  robot.push_back(config.step_times_are_given ? "step.planner=icp_formula" : "step.planner=ocp");
  robot = list(robot, config.step_times_are_given ? of_formula : of_ocp);

  s.choice("preset", config.preset, {"paper", "robot"},
           "conditions of the paper, or of the real robot (default for the whole body); keys that "
           "are given take precedence");
  s.preset("plant", {"dart", "mujoco"}, list({"preset=robot"}, robot));
  s.preset("preset", {"paper"}, paper);
  s.preset("preset", {"robot"}, robot);
  // Heavy rotors make the legs slow and their landings hard. The motion is therefore planned with
  // the rotors, the swing foot stays low and touches the ground slowly, and the stance foot returns
  // to the ground when the shock of the landing lifts it. Drives that hold the motion as springs
  // would keep soles from turning with the ground. A real robot also differs from its model.
  s.choice("drives", config.drives, {"ideal", "real"},
           "whole body: torques act as commanded, or through the drives of the robot's file (rotor "
           "inertia, friction, torque-speed line), which the controllers know; real is the default "
           "of preset robot if that file has drives; keys that are given take precedence");
  s.preset("drives", {"real"},
           {"drive.rotor_inertia=1", "drive.friction=1", "drive.torque_speed_line=true",
            "model.rotor_inertia=1", "model.friction=1", "swing.clearance_m=0.012",
            "swing.apex=0.45", "swing.touch_speed_m_per_s=0.05", "whole_body.swing_foot=400",
            "whole_body.angular_momentum=20", "whole_body.stance_stiffness=1500",
            "whole_body.stance_damping=60", "whole_body.estimate_support=true",
            "whole_body.estimate_mass=true", "sensor.rocking_walk=0.02",
            "weights.gamma=0,0,100000,1000,1000,30000,400,400,400", "mpc.capturing_momentum=1.2",
            "posture=bent"});
  // A single step of the foot in the air does not help a robot on two feet. Its CoM comes to rest
  // midway between heels and toes. Its usual posture has bent knees.
  s.preset("stance", {"both"},
           list({"step.planner=reactive", "target=centroid", "posture="}, of_formula));
  s.preset("step.planner", {"push_formula", "icp_formula", "reactive"}, of_formula);
  s.preset("step.planner", {"ocp"}, of_ocp);
}

// Text of a key with one value; empty if it is not given.
std::string text_of(const std::vector<Assignment>& all, std::string_view key) {
  const auto it = std::ranges::find(all, key, &Assignment::key);
  return it == all.end() || it->items.size() != 1 ? "" : it->items.front();
}
std::string text_of(const std::vector<Assignment>& first, const std::vector<Assignment>& second,
                    std::string_view key) {
  const std::string text = text_of(first, key);
  return text.empty() ? text_of(second, key) : text;
}
std::string preset_of(const std::vector<Assignment>& first, const std::vector<Assignment>& second) {
  std::string given = text_of(first, second, "preset");
  if (!given.empty()) return given;
  const std::string plant = text_of(first, second, "plant");
  return plant.empty() || plant == "centroidal" ? "paper" : "robot";
}

// Preset `robot` has real drives if the robot's file has them. Robots other than iCub may have no
// posture with bent knees.
void choose_drives(std::vector<Assignment>& file, const std::vector<Assignment>& command_line) {
  if (preset_of(command_line, file) != "robot" || !text_of(command_line, file, "drives").empty())
    return;
  const std::string description = text_of(command_line, file, "robot.config");
  bool has_drives = true, has_bent_knees = true;
  if (!description.empty()) {
    try {
      const robots::RobotDescription robot =
          robots::read_robot_description(description, robots::RobotDescription::Figures::from_urdf);
      has_drives = std::ranges::any_of(robot.joints,
                                       [](const auto& joint) { return !joint.drive.is_ideal(); });
      has_bent_knees = std::ranges::any_of(
          robot.postures, [](const auto& posture) { return posture.name.ends_with("bent"); });
    } catch (const InputError&) {
      return;  // the run reports it
    }
  }
  if (!has_drives) return;
  file.push_back(parse_set_argument("drives=real"));
  const bool is_posture_given =
      std::ranges::find(file, "posture", &Assignment::key) != file.end() ||
      std::ranges::find(command_line, "posture", &Assignment::key) != command_line.end();
  if (!has_bent_knees && !is_posture_given) file.push_back(parse_set_argument("posture="));
}

// Replaces the keys step.known and step.trigger of version 0.2, and step.planner=formula, which
// depended on them.
class OldStepKeys {
 public:
  OldStepKeys(std::vector<Assignment>& given, const std::vector<Assignment>& others)
      : given_(given), others_(others) {}

  std::vector<std::string> translate() {
    const std::string planner = text_of(given_, "step.planner");
    const std::string known = text_of(given_, "step.known");
    const std::string trigger = text_of(given_, "step.trigger");
    if (known.empty() && trigger.empty() && planner != "formula") return {};
    const bool is_formula = planner.empty() || planner == "formula";
    if (known == "true" && !is_formula)
      refuse("step.known",
             "step.known=true now means step.planner=push_formula, but step.planner=" + planner +
                 " is given; remove one of them");
    if (is_formula &&
        ((known == "true" && trigger == "icp") || (known == "false" && trigger == "push")))
      refuse("step.known", "step.known=" + known + " contradicts step.trigger=" + trigger +
                               "; use step.planner=push_formula or step.planner=icp_formula");
    std::string now = planner;
    if (is_formula) {
      const bool is_told = known.empty() && trigger.empty() ? preset_of(given_, others_) == "paper"
                                                            : known == "true" || trigger == "push";
      now = is_told ? "push_formula" : "icp_formula";
      // With preset `robot` or on two feet, step.known=false did not select a planner: the default
      // applies.
      if (planner.empty() && !is_told &&
          (preset_of(given_, others_) == "robot" || text_of(given_, others_, "stance") == "both"))
        now.clear();
    }
    return replace_by(now);
  }

 private:
  [[noreturn]] void refuse(std::string_view key, const std::string& why) const {
    throw InputError(std::ranges::find(given_, key, &Assignment::key)->location + ": " + why);
  }
  std::vector<std::string> replace_by(const std::string& now) {
    std::vector<std::string> warnings;
    Assignment planner = parse_set_argument("step.planner=" + (now.empty() ? "none" : now));
    std::erase_if(given_, [&](const Assignment& a) {
      const bool is_old = a.key == "step.known" || a.key == "step.trigger";
      if (is_old || (a.key == "step.planner" && a.items.front() != now)) {
        warnings.push_back(
            fmt::format("{}: {}={} is replaced by {}; the old form is rejected from 0.4 on",
                        a.location, a.key, fmt::join(a.items, ","),
                        now.empty() ? "the value of step.planner" : "step.planner=" + now));
        planner.location = a.location;
      }
      return is_old || a.key == "step.planner";
    });
    if (!now.empty()) given_.push_back(std::move(planner));
    return warnings;
  }

  std::vector<Assignment>& given_;
  const std::vector<Assignment>& others_;
};

}  // namespace

void declare_settings(Settings& s, Config& config) {
  declare_biped(s, config);
  declare_weights(s, config.weights);
  declare_momentum(s, config);
  declare_settings(s, config.planning, config.step);
  s.rule({"walk.velocity", "controller"}, [&config] {
    return config.planning.velocity[2] != 0.0 && config.controller != BipedSettings::Controller::mpc
               ? "walk.velocity has a yaw rate, which needs controller=mpc: the other controller "
                 "takes the feet for parallel"
               : "";
  });
  declare_pictures(s, config);
  declare_presets(s, config);
  s.translate([](std::vector<Assignment>& file, std::vector<Assignment>& command_line) {
    std::vector<std::string> warnings = OldStepKeys(file, command_line).translate();
    for (std::string& more : OldStepKeys(command_line, file).translate())
      warnings.push_back(std::move(more));
    choose_drives(file, command_line);
    return warnings;
  });
}

}  // namespace saltus::push_recovery
