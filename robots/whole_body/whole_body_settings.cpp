#include "saltus/robots/whole_body/whole_body_settings.hpp"

#include "saltus/app/settings.hpp"

namespace saltus {

std::unique_ptr<WholeBodyController> make_whole_body_controller(const FloatingRobot& robot,
                                                                const ContactConeOptions& left,
                                                                const ContactConeOptions& right,
                                                                const WholeBodyControl& control) {
  if (control.choice == WholeBodyChoice::momentum)
    return make_momentum_controller(robot, left, right, control.momentum);
  return make_inverse_dynamics_controller(robot, left, right, control.inverse_dynamics);
}

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
  WholeBodyWeights& w = control.inverse_dynamics;
  s.number("whole_body.linear_momentum", w.linear_momentum, "1/N^2", "weight", at_least(0.0));
  s.number("whole_body.angular_momentum", w.angular_momentum, "1/(Nm)^2", "weight", at_least(0.0));
  s.number("whole_body.posture", w.posture, "s^4/rad^2", "weight", above(0.0));
  s.number("whole_body.swing_foot", w.swing_foot, "s^4/m^2", "weight", at_least(0.0));
  s.number("whole_body.wrench", w.wrench, "1/N^2", "weight", above(0.0));
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

}  // namespace saltus
