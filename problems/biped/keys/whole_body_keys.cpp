#include "problems/biped/keys/keys.hpp"

#include <utility>

#include "saltus/app/settings.hpp"

namespace saltus::walking {

void declare_period(Settings& s, WholeBodyControl& control) {
  s.number("control.period", control.period, "s",
           "of the whole-body controller; a whole multiple of simulator.step_s", above(0.0));
}

void declare_settings(Settings& s, WholeBodyControl& control) {
  s.choice<WholeBodyChoice>(
      "whole_body.controller", control.choice,
      {{"inverse_dynamics", WholeBodyChoice::inverse_dynamics},
       {"momentum", WholeBodyChoice::momentum}},
      "one program over accelerations and wrenches, or the momentum control of the literature "
      "(wrenches first, then torques)");
  s.flag("self_collision", control.self_collision,
         "whole body: limbs collide with each other and with the ground, and the program of "
         "inverse_dynamics keeps them off each other");
  s.flag("joint_speed_limits", control.joint_speed_limits,
         "whole body: the program of inverse_dynamics keeps joints below their largest speeds and "
         "lets them brake before their limits");
  WholeBodyWeights& w = control.inverse_dynamics;
  s.number("whole_body.linear_momentum", w.linear_momentum, "1/N^2", "weight", at_least(0.0));
  s.number("whole_body.angular_momentum", w.angular_momentum, "1/(Nm)^2", "weight", at_least(0.0));
  s.number("whole_body.posture", w.posture, "s^4/rad^2", "weight", above(0.0));
  s.number("whole_body.wrench", w.wrench, "1/N^2", "weight", above(0.0));
  WholeBodyGains& g = control.gains;
  s.number("whole_body.stance_damping", g.stance_damping, "1/s",
           "gain on what is left of a stance foot's twist", at_least(0.0));
  s.number("whole_body.tipped_reserve", g.tipped_reserve, "",
           "a sole that has tipped onto a corner keeps its centre of pressure off the edges that "
           "bear by so much of what the opposite ones are lifted, up to 10 mm; 0: it may stay",
           at_least(0.0));
  MomentumOptions& m = control.momentum;
  s.number("momentum.linear_momentum", m.linear_momentum, "1/N^2", "weight", at_least(0.0));
  s.number("momentum.angular_momentum", m.angular_momentum, "1/(Nm)^2", "weight", at_least(0.0));
  s.number("momentum.wrench", m.wrench, "1/N^2", "weight of the difference to the plan",
           above(0.0));
}

void declare_settings(Settings& s, SensorOptions& o, EstimationOptions& e) {
  const std::pair<const char*, double*> delays[] = {
      {"sensor.encoder.delay_s", &o.encoder.delay},
      {"sensor.gyroscope.delay_s", &o.gyroscope.delay},
      {"sensor.accelerometer.delay_s", &o.accelerometer.delay},
      {"sensor.force_torque.delay_s", &o.force_torque.delay}};
  for (const auto& [key, delay] : delays)
    s.number(key, *delay, "s", "rounded to whole steps of the simulator", between(0.0, 1.0));
  s.number("sensor.velocity_lag_s", e.velocity_lag, "s",
           "time constant of the filter of the joint velocities", at_least(0.0));
  s.number("sensor.standing_force", e.standing_force, "N", "a foot that bears more is a landmark",
           at_least(0.0));
  s.integer("sensor.seed", o.seed, "", "of the noise, the biases and the first estimate",
            at_least(0.0));
}

}  // namespace saltus::walking
