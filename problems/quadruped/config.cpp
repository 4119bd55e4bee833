#include "problems/quadruped/config.hpp"

#include <fmt/format.h>

#include <utility>

namespace saltus::quadruped {

void declare_settings(Settings& s, Config& c) {
  ControllerSettings& k = c.controller;
  s.choice("gait", c.gait, {"trot", "walk", "pace"},
           "legs that swing together: diagonal pairs, none, or the legs of one side");
  s.number("period", k.gait.period, "s",
           "gait period, from lift-off to lift-off of a leg; at least the horizon of the plan",
           between(0.45, 1.5));
  s.flag("blind", k.gait.blind, "contacts follow the clock alone, and not the sensed touch-downs");
  s.number("speed", k.speed, "m/s", "forward velocity", between(-1.0, 1.0));
  s.number("sideways", k.sideways, "m/s", "velocity to the left", between(-0.5, 0.5));
  s.number("turn", k.turn, "rad/s", "turning rate to the left", between(-1.0, 1.0));
  s.number("duration", c.duration, "s", "duration of the run", between(0.1, 600.0));
  s.number("ground.roughness_m", c.roughness, "m",
           "height of the uneven ground: nearly all of it lies within this height; the controller "
           "assumes level ground",
           between(0.0, 0.1));
  s.number("ground.friction", c.plant.friction, "", "friction coefficient of the ground",
           between(0.05, 2.0));
  s.number("push.impulse", c.push.impulse, "N s", "impulse on the body, spread over push.duration",
           between(0.0, 50.0));
  s.number("push.towards_deg", c.towards, "deg",
           "direction of the push; 0: forward, 90: to the left", between(-360.0, 360.0));
  s.number("push.start", c.push.start, "s", "start of the push", between(0.0, 600.0));
  s.number("push.duration", c.push.duration, "s", "duration of the push", between(0.01, 1.0));
  s.number("noise", c.noise, "",
           "measurement noise of the body; 1 means 2 mm, 2 cm/s, 0.3 deg and 3 deg/s",
           between(0.0, 10.0));
  s.integer("seed", c.seed, "", "seed of the ground, of the noise and of a campaign",
            between(0, 1000000));
  s.integer("campaign.runs", c.runs, "",
            "number of random grounds and pushes, each run with contact sensing and blind; 0: a "
            "single run",
            between(0, 10000));
  s.number("campaign.size", c.scale, "", "factor on roughness and push in a campaign",
           between(0.0, 10.0));
  s.number("controller.period", k.period, "s", "control period", between(0.001, 0.05));
  s.number("controller.friction", k.model.friction, "", "friction coefficient in the plan",
           between(0.05, 2.0));
  s.number("controller.height", k.height, "m", "height of the centre of mass above the feet",
           between(0.2, 0.35));
  s.number("controller.clearance", k.clearance, "m", "height of a swing foot above the ground",
           between(0.01, 0.15));
  s.number("controller.landing_speed", k.landing_speed, "m/s",
           "downward speed of a landing foot; a late foot searches for the ground at this speed",
           between(0.1, 1.0));
  s.number("controller.foothold_gain_s", k.foothold_gain, "s",
           "displacement of a foothold per error of the velocity", between(0.0, 0.5));
  s.vector("weights.state", k.weights.state, "",
           "weights of position (m), velocity (m/s), angles (rad) and angular velocity (rad/s)",
           at_least(0.0));
  s.number("weights.force", k.weights.force, "", "weight of the forces of the feet (N)",
           at_least(0.0));
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
