#include "problems/push_recovery/config.hpp"

#include "problems/biped/keys/keys.hpp"
#include "saltus/app/settings.hpp"

namespace saltus::push_recovery {
namespace {

void declare_weights(Settings& s, Weights& w) {
  s.vector("weights.gamma", w.gamma, "", "on CoM, CoM velocity and angular momentum, all along",
           at_least(0.0));
  s.vector("weights.gamma_impact", w.gamma_impact, "",
           "the same, added after the impact and at "
           "the end of the horizon",
           at_least(0.0));
  s.vector("weights.wrench", w.wrench, "", "on force (N) and torque (Nm) of each foot",
           at_least(0.0));
  s.vector("weights.capture_point", w.capture_point, "", "on the capture point after the impact",
           at_least(0.0));
  s.vector("weights.capture_point_standing", w.capture_point_standing, "",
           "on the capture point as long as no step is planned", at_least(0.0));
  s.number("weights.wrench_change", w.wrench_change, "", "on first differences of the wrenches",
           at_least(0.0));
  s.number("weights.capture_point_softness", w.capture_point_penalty, "1/(m s)",
           "penalty on a capture point outside the hull; 0 forbids it", at_least(0.0));
}

// How much of the real robot is looked at. Both presets name the same keys.
void declare_presets(Settings& s, Config& config) {
  s.preset("preset", config.preset,
           {{"paper",
             {"step.duration=0.6", "step.known=true", "step.trigger=push", "step.decide=always",
              "step.decision_lead=none", "sensors=ideal", "self_collision=false",
              "joint_speed_limits=false", "whole_body.stance_damping=50",
              "contact.friction=0.3333333333333333", "contact.corners=false", "dart.friction=box"}},
            {"robot",
             {"step.duration=0.5",  // about 0.56 s from the push
              "step.known=false", "step.trigger=icp", "step.decide=if_it_helps",
              "step.decision_lead=0.1", "sensors=measured", "self_collision=true",
              "joint_speed_limits=true", "whole_body.stance_damping=30",
              // A foot that has just landed, lightly loaded on a corner, turns under more.
              "contact.friction=0.25", "contact.corners=true", "dart.friction=inscribed"}}},
           "the conditions of the paper or those of the real robot, which are the default of the "
           "whole body; keys that are given win");
  // One step of the foot in the air is of no use to a robot on two feet; the CoM shall come to rest
  // where heels and toes are equally far.
  s.implies("stance", {"both"}, "step.planner=reactive");
  s.implies("stance", {"both"}, "target=centroid");
  s.implies("plant", {"dart", "mujoco"}, "preset=robot");
  // Only the formula can be told of the push, and counts from it then. A planner that is asked for
  // decides first: to others the trigger is of no matter.
  s.implies("step.planner", {"reactive", "ocp"}, "step.known=false");
  s.implies("step.trigger", {"push"}, "step.known=true");
  s.implies("step.trigger", {"icp"}, "step.known=false");
  s.implies("step.known", {"true"}, "step.trigger=push");
  s.implies("step.known", {"true"}, "step.planner=formula");
  s.implies("step.known", {"false"}, "step.trigger=icp");
  // Nobody tells the robot when, where and how fast to step.
  if (!config.step_times_are_given) s.implies("preset", {"robot"}, "step.planner=ocp");
  // The rule looks at its shortest time last, the optimum only where it must.
  s.implies("step.planner", {"ocp"}, "step.shortest=0.25");
  // Its plans rest on the corners of the stance sole, which would turn under.
  s.implies("step.planner", {"ocp"}, "whole_body.tipped_reserve=10");
}

}  // namespace

void declare_settings(Settings& s, Config& config) {
  declare_biped(s, config);
  declare_weights(s, config.weights);
  declare_settings(s, config.planning, config.step);
  declare_pictures(s, config);
  declare_presets(s, config);
}

}  // namespace saltus::push_recovery
