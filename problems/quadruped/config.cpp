#include "problems/quadruped/config.hpp"

#include <fmt/format.h>

#include <utility>

namespace saltus::quadruped {

void declare_settings(Settings& s, Config& c) {
  ControllerSettings& k = c.controller;
  s.choice("gait", c.gait, {"trot", "walk", "pace"},
           "which legs swing together: diagonal ones, none, those of a side");
  s.number("period", k.gait.period, "s",
           "from lift-off to lift-off of a leg; not less than the plan looks ahead",
           between(0.45, 1.5));
  s.flag("blind", k.gait.blind,
         "the clock alone decides when a foot stands, not when it touches the ground");
  s.number("speed", k.speed, "m/s", "ahead", between(-1.0, 1.0));
  s.number("sideways", k.sideways, "m/s", "to the left", between(-0.5, 0.5));
  s.number("turn", k.turn, "rad/s", "to the left", between(-1.0, 1.0));
  s.number("duration", c.duration, "s", "of the run", between(0.1, 600.0));
  s.number("ground.roughness_m", c.roughness, "m",
           "the ground, which the controller takes for level, is nearly all within so much of it",
           between(0.0, 0.1));
  s.number("ground.friction", c.plant.friction, "", "of the ground", between(0.05, 2.0));
  s.number("push.impulse", c.push.impulse, "N s", "on the body, in push.duration",
           between(0.0, 50.0));
  s.number("push.towards_deg", c.towards, "deg", "0: ahead, 90: to the left",
           between(-360.0, 360.0));
  s.number("push.start", c.push.start, "s", "when it begins", between(0.0, 600.0));
  s.number("push.duration", c.push.duration, "s", "how long it lasts", between(0.01, 1.0));
  s.number("noise", c.noise, "", "of the measured body: 1 is 2 mm, 2 cm/s, 0.3 deg, 3 deg/s",
           between(0.0, 10.0));
  s.integer("seed", c.seed, "", "of the ground, of the noise and of a campaign",
            between(0, 1000000));
  s.integer("campaign.runs", c.runs, "",
            "so many random grounds and pushes, with open eyes and blind; 0: one run",
            between(0, 10000));
  s.number("campaign.size", c.scale, "", "of roughness and push, as a multiple of both",
           between(0.0, 10.0));
  s.number("controller.period", k.period, "s", "of a tick", between(0.001, 0.05));
  s.number("controller.friction", k.model.friction, "", "that the plan counts on",
           between(0.05, 2.0));
  s.number("controller.height", k.height, "m", "of the centre of mass above the feet",
           between(0.2, 0.35));
  s.number("controller.clearance", k.clearance, "m", "of a swing foot", between(0.01, 0.15));
  s.number("controller.landing_speed", k.landing_speed, "m/s",
           "of a swing foot, downwards; one that is late looks for the ground so fast",
           between(0.1, 1.0));
  s.number("controller.foothold_gain_s", k.foothold_gain, "s",
           "how far ahead a foot lands for an error of the velocity", between(0.0, 0.5));
  s.vector("weights.state", k.weights.state, "",
           "on position (m), velocity (m/s), angles (rad), angular velocity (rad/s)",
           at_least(0.0));
  s.number("weights.force", k.weights.force, "", "on forces of the feet (N)", at_least(0.0));
  for (const auto& [old_key, key] : {std::pair{"push.towards", "push.towards_deg"},
                                     {"ground.roughness", "ground.roughness_m"},
                                     {"controller.foothold_gain", "controller.foothold_gain_s"}})
    s.renamed(old_key, key, "0.4");
  s.flag("pictures", c.pictures, "draw the picture at the end (needs python3 with matplotlib)");
}

void apply_gait(const std::string& name, GaitSettings& gait) {
  if (name == "walk") {
    gait.lifts_at = {0.25, 0.75, 0.0, 0.5};
    gait.duty = 0.78;
  } else if (name == "pace") {
    gait.lifts_at = {0.0, 0.5, 0.0, 0.5};
  }
}

}  // namespace saltus::quadruped
