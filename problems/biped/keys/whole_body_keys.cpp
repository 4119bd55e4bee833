#include "problems/biped/keys/keys.hpp"

#include <fmt/format.h>

#include <string>
#include <tuple>

#include "saltus/app/settings.hpp"

namespace saltus::walking {

void declare_period(Settings& s, WholeBodyControl& control) {
  s.number("control.period", control.period, "s",
           "of the whole-body controller; a whole multiple of simulator.step", above(0.0));
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
  s.number("whole_body.swing_foot", w.swing_foot, "s^4/m^2", "weight", at_least(0.0));
  s.number("whole_body.wrench", w.wrench, "1/N^2", "weight", above(0.0));
  WholeBodyGains& g = control.gains;
  s.number("whole_body.posture_stiffness", g.posture, "1/s^2", "gain", at_least(0.0));
  s.number("whole_body.posture_damping", g.posture_damping, "1/s", "gain", at_least(0.0));
  s.number("whole_body.stance_damping", g.stance_damping, "1/s",
           "gain on what is left of a stance foot's twist", at_least(0.0));
  s.number("whole_body.tipped_reserve", g.tipped_reserve, "",
           "a sole that has tipped onto a corner keeps its centre of pressure off the edges that "
           "bear by so much of what the opposite ones are lifted, up to 10 mm; 0: it may stay",
           at_least(0.0));
  s.number("whole_body.clearance", g.clearance_margin, "m",
           "that limbs keep from each other, with self_collision", at_least(0.0));
  MomentumOptions& m = control.momentum;
  s.number("momentum.linear_momentum", m.linear_momentum, "1/N^2", "weight", at_least(0.0));
  s.number("momentum.angular_momentum", m.angular_momentum, "1/(Nm)^2", "weight", at_least(0.0));
  s.number("momentum.wrench", m.wrench, "1/N^2", "weight of the difference to the plan",
           above(0.0));
  s.number("momentum.torque", m.torque, "1/(Nm)^2", "weight", at_least(0.0));
  s.number("momentum.posture", m.posture, "1/s^2", "stiffness", at_least(0.0));
  s.number("momentum.posture_damping", m.posture_damping, "1/s", "of the same", at_least(0.0));
  s.number("momentum.swing_regularisation", m.swing_regularisation, "m/(s^2 Nm)",
           "of the pseudo-inverse", above(0.0));
}

void declare_settings(Settings& s, MeasurementNoise& n) {
  s.number("noise.position", n.position, "m", "whole body: standard deviation, base's position",
           at_least(0.0));
  s.number("noise.angle", n.angle, "rad", "whole body: base's orientation and joints",
           at_least(0.0));
  s.number("noise.velocity", n.velocity, "m/s",
           "whole body: base's velocity, as an estimator leaves it", at_least(0.0));
  s.number("noise.angular_velocity", n.angular_velocity, "rad/s",
           "whole body: angular velocity of the base, velocities of the joints, likewise",
           at_least(0.0));
  s.number("noise.force", n.force, "",
           "whole body: relative, wrenches measured at the feet; only the landing is told by them",
           at_least(0.0));
  s.integer("noise.seed", n.seed, "", "which noise", at_least(0.0));
}

void declare_settings(Settings& s, SensorOptions& o, EstimationOptions& e) {
  const auto device = [&s](const std::string& name, double& rate, double& delay) {
    s.number("sensor." + name + ".rate", rate, "Hz", "measured senses", between(1.0, 1e5));
    s.number("sensor." + name + ".delay", delay, "s", "whole steps of the engine",
             between(0.0, 1.0));
  };
  const auto deviation = [&s](const std::string& key, double& field, const char* unit,
                              const char* doc) {
    s.number("sensor." + key, field, unit, doc, at_least(0.0));
  };
  device("encoder", o.encoder.rate, o.encoder.delay);
  deviation("encoder.resolution", o.encoder.resolution, "rad", "of every joint");
  deviation("encoder.noise", o.encoder.noise, "rad", "standard deviation, each sample");
  deviation("encoder.bias", o.encoder.bias, "rad", "standard deviation of the zeros");
  for (const auto& [name, inertial, unit] :
       {std::tuple{"gyroscope", &o.gyroscope, "rad/s"},
        std::tuple{"accelerometer", &o.accelerometer, "m/s^2"}}) {
    device(name, inertial->rate, inertial->delay);
    deviation(fmt::format("{}.noise", name), inertial->noise, unit, "density, per sqrt(Hz)");
    deviation(fmt::format("{}.bias", name), inertial->bias, unit, "standard deviation");
  }
  ForceTorqueOptions& f = o.force_torque;
  device("force_torque", f.rate, f.delay);
  deviation("force_torque.force_noise", f.force_noise, "N", "standard deviation, each sample");
  deviation("force_torque.torque_noise", f.torque_noise, "Nm", "the same");
  deviation("force_torque.force_bias", f.force_bias, "N", "standard deviation");
  deviation("force_torque.torque_bias", f.torque_bias, "Nm", "the same");
  deviation("velocity_lag", e.velocity_lag, "s", "of the joints' velocities, by their filter");
  deviation("standing_force", e.standing_force, "N", "a foot that bears more is a landmark");
  deviation("initial_tilt", e.initial_tilt, "rad", "standard deviation of the first estimate");
  s.integer("sensor.seed", o.seed, "", "which noise, biases and first estimate", at_least(0.0));
}

}  // namespace saltus::walking
