#include "problems/biped/keys/keys.hpp"

#include <utility>

#include "saltus/app/settings.hpp"

namespace saltus::robots::walking {

void declare_period(Settings& s, WholeBodyController::Options& control) {
  s.number("control.period", control.period, "s",
           "period of the whole-body controller; a whole multiple of simulator.step_s", above(0.0));
}

void declare_settings(Settings& s, WholeBodyController::Options& control) {
  s.choice<WholeBodyController::Method>(
      "whole_body.controller", control.choice,
      {{"inverse_dynamics", WholeBodyController::Method::inverse_dynamics},
       {"momentum", WholeBodyController::Method::momentum}},
      "inverse dynamics as one program over accelerations and wrenches, or "
      "momentum control as in the literature (wrenches first, then torques)");
  s.flag("self_collision", control.self_collision,
         "whole body: limbs collide with each other and with the ground, and inverse_dynamics "
         "keeps them apart");
  s.flag("joint_speed_limits", control.joint_speed_limits,
         "whole body: inverse_dynamics limits the joint speeds and brakes the joints before their "
         "position limits");
  WholeBodyController::Weights& w = control.inverse_dynamics;
  s.number("whole_body.linear_momentum", w.linear_momentum, "1/N^2",
           "weight of the error in the rate of the linear momentum", at_least(0.0));
  s.number("whole_body.angular_momentum", w.angular_momentum, "1/(Nm)^2",
           "weight of the error in the rate of the angular momentum", at_least(0.0));
  s.number("whole_body.posture", w.posture, "s^4/rad^2",
           "weight of the error in the joint accelerations", above(0.0));
  s.number("whole_body.swing_foot", w.swing_foot, "s^4/m^2",
           "weight of the error in the acceleration of the swing foot", above(0.0));
  s.number("whole_body.wrench", w.wrench, "1/N^2",
           "weight of the difference between wrenches and plan", above(0.0));
  WholeBodyController::Gains& g = control.gains;
  s.number("whole_body.stance_damping", g.stance_damping, "1/s",
           "gain on the remaining twist of a stance foot", at_least(0.0));
  s.number("whole_body.tipped_reserve", g.tipped_reserve, "",
           "distance of the centre of pressure from the loaded edge of a tipped sole, as a "
           "multiple of the height of the opposite edge, at most 10 mm; 0: none",
           at_least(0.0));
  WholeBodyController::MomentumOptions& m = control.momentum;
  s.number("momentum.linear_momentum", m.linear_momentum, "1/N^2",
           "weight of the error in the rate of the linear momentum", at_least(0.0));
  s.number("momentum.angular_momentum", m.angular_momentum, "1/(Nm)^2",
           "weight of the error in the rate of the angular momentum", at_least(0.0));
  s.number("momentum.wrench", m.wrench, "1/N^2",
           "weight of the difference between wrenches and plan", above(0.0));
}

void declare_settings(Settings& s, StanceFootOptions& stance) {
  s.number("whole_body.stance_stiffness", stance.stiffness, "1/s^2",
           "gain with which a stance foot returns to the place where it last carried load",
           at_least(0.0));
}

void declare_settings(Settings& s, FootSupportOptions& support) {
  s.flag("whole_body.estimate_support", support.is_estimated,
         "estimate from the forces on a foot which part of its sole the ground supports, and shift "
         "load onto it only as it is carried");
}

void declare_settings(Settings& s, MassEstimateOptions& estimate) {
  s.flag("whole_body.estimate_mass", estimate.is_estimated,
         "estimate mass and CoM of the controllers' model from the forces of the ground");
}

void declare_settings(Settings& s, SwingOptions& swing) {
  s.number("swing.clearance_m", swing.clearance, "m",
           "largest height of the swing foot above the ground", above(0.0));
  s.number("swing.apex", swing.apex, "", "time of the largest height, as a fraction of the swing",
           between(0.1, 0.9));
  s.number("walk.clearance_m", swing.walking_clearance, "m",
           "largest height of the swing foot above the ground while walking", above(0.0));
  s.number("swing.touch_speed_m_per_s", swing.touch_speed, "m/s",
           "speed with which the swing foot descends through the last 5 mm; 0: it lands at rest",
           between(0.0, 1.0));
}

void declare_settings(Settings& s, DriveController::Options& drive) {
  s.number("drive.stiffness", drive.stiffness, "1/rad",
           "whole body: stiffness of the joints around their planned motion, as a multiple of the "
           "largest torque",
           at_least(0.0));
  s.number("drive.damping", drive.damping, "s/rad",
           "whole body: damping of the joints around their planned motion, as a multiple of the "
           "largest torque",
           at_least(0.0));
}

void declare_settings(Settings& s, SensorOptions& o, Estimator::Options& e) {
  const std::pair<const char*, double*> delays[] = {
      {"sensor.encoder.delay_s", &o.encoder.delay},
      {"sensor.gyroscope.delay_s", &o.gyroscope.delay},
      {"sensor.accelerometer.delay_s", &o.accelerometer.delay},
      {"sensor.force_torque.delay_s", &o.force_torque.delay}};
  for (const auto& [key, delay] : delays)
    s.number(key, *delay, "s", "delay, rounded to whole steps of the simulator", between(0.0, 1.0));
  s.number("sensor.velocity_lag_s", e.velocity_lag, "s",
           "time constant of the filter of the joint velocities", at_least(0.0));
  s.number("sensor.standing_force", e.standing_force, "N",
           "a foot with a larger normal force is a landmark of the estimator", at_least(0.0));
  s.number("sensor.rocking_walk", e.rocking_walk, "m/s^0.5",
           "random walk, in the estimator, of the stance foot while it stands on an edge; 0: it "
           "does not move",
           between(0.0, 1.0));
  s.integer("sensor.seed", o.seed, "", "seed of the noise, the biases and the initial estimate",
            at_least(0.0));
}

}  // namespace saltus::robots::walking
