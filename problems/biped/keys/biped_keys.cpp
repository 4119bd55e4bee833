#include "problems/biped/keys/keys.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <utility>
#include <vector>

#include "saltus/app/settings.hpp"

namespace saltus::robots::walking {
namespace {

bool is_multiple(double whole, double part) {
  constexpr double rounding = 1e-6;  // rounding error of decimals without exact binary form
  const double ratio = whole / part;
  return ratio > 0.5 && std::abs(ratio - std::round(ratio)) < rounding * ratio;
}

// The loop on the whole body counts steps of the engine, so every period must be a whole number of
// them.
std::string clock_complaint(const BipedSettings& c) {
  if (c.plant.choice == PlantSettings::Choice::centroidal) return "";
  if (!is_multiple(c.control.period, c.plant.engine.step))
    return fmt::format("control.period ({} s) must be a whole multiple of simulator.step_s ({} s)",
                       c.control.period, c.plant.engine.step);
  if (!is_multiple(c.planner.step, c.control.period))
    return fmt::format("mpc.step_s ({} s) must be a whole multiple of control.period ({} s)",
                       c.planner.step, c.control.period);
  return "";
}

// Keys of version 0.2 that did not name their unit.
void declare_renamed(Settings& s) {
  const std::pair<const char*, std::vector<const char*>> keys_of_unit[] = {
      {"_s",
       {"push.random.until", "push.random.apart", "step.decision_lead", "mpc.step", "mpc.deadline",
        "capture_point.after_landing", "simulator.step", "sensor.encoder.delay",
        "sensor.gyroscope.delay", "sensor.accelerometer.delay", "sensor.force_torque.delay",
        "sensor.velocity_lag", "explain_limit"}},
      {"_hz", {"push.random.rate", "motor.bandwidth"}},
      {"_m", {"simulator.ground_step", "simulator.ground_edge", "contact.torsional_friction"}},
      {"_nms_per_rad", {"simulator.joint_friction"}}};
  for (const auto& [unit, keys] : keys_of_unit)
    for (const std::string key : keys) s.renamed(key, key + unit, "0.4");
}

// Keys of version 0.2 whose values are now constants in the option structs.
void declare_removed(Settings& s) {
  constexpr std::pair<const char*, const char*> keys[] = {
      {"mpc.costs", "nodes"},
      {"mpc.missed_share", "0"},
      {"mpc.missed_seed", "1"},
      {"capture_point.com_stiffness", "50"},
      {"capture_point.com_damping", "14.1"},
      {"capture_point.momentum_damping", "5"},
      {"contact.pyramid", "inscribed"},
      {"noise.position", "0"},
      {"noise.angle", "0"},
      {"noise.velocity", "0"},
      {"noise.angular_velocity", "0"},
      {"noise.force", "0"},
      {"noise.seed", "1"},
      {"sensor.encoder.rate", "1000"},
      {"sensor.encoder.resolution", "4.4e-06"},
      {"sensor.encoder.noise", "2e-05"},
      {"sensor.encoder.bias", "0.00044"},
      {"sensor.gyroscope.rate", "1000"},
      {"sensor.gyroscope.noise", "0.000175"},
      {"sensor.gyroscope.bias", "0.0035"},
      {"sensor.accelerometer.rate", "1000"},
      {"sensor.accelerometer.noise", "0.00059"},
      {"sensor.accelerometer.bias", "0.03"},
      {"sensor.force_torque.rate", "100"},
      {"sensor.force_torque.force_noise", "0.25"},
      {"sensor.force_torque.torque_noise", "0.005"},
      {"sensor.force_torque.force_bias", "2"},
      {"sensor.force_torque.torque_bias", "0.1"},
      {"sensor.initial_tilt", "0.01"},
      {"step.decision_delay", "0.1"},
      {"whole_body.posture_stiffness", "100"},
      {"whole_body.posture_damping", "20"},
      {"whole_body.clearance", "0.005"},
      {"momentum.torque", "0"},
      {"momentum.posture", "50"},
      {"momentum.posture_damping", "14"},
      {"momentum.swing_regularisation", "0.1"}};
  for (const auto& [key, value] : keys) s.removed(key, value, "0.4");
}

}  // namespace

void declare_biped(Settings& s, BipedSettings& biped) {
  declare_plant(s, biped.plant);
  declare_settings(s, biped.robot);
  s.choice<BipedSettings::Controller>(
      "controller", biped.controller,
      {{"mpc", BipedSettings::Controller::mpc},
       {"capture_point", BipedSettings::Controller::capture_point}},
      "receding-horizon control, or the capture-point controller without prediction");
  declare_solver(s, biped.planner);
  declare_stance(s, biped.scene);
  declare_stepping(s, biped.step);
  declare_mass_error(s, biped.robot);
  declare_target(s, biped.scene);
  declare_settings(s, biped.push);
  declare_settings(s, biped.more_pushes, biped.push);
  declare_settings(s, biped.step);
  declare_settings(s, biped.planner);
  s.number("capture_point.after_landing_s", biped.baseline.after_landing, "s",
           "controller=capture_point: end of the CoM trajectory, counted from the landing",
           above(0.0));
  declare_settings(s, biped.contact);
  declare_point_of_push(s, biped.push);
  declare_period(s, biped.control);
  declare_step(s, biped.plant);
  s.rule({"control.period", "mpc.step_s", "simulator.step_s"},
         [&biped] { return clock_complaint(biped); });
  declare_settings(s, biped.plant);
  declare_settings(s, biped.control);
  declare_settings(s, biped.stance_foot);
  declare_settings(s, biped.foot_support);
  declare_settings(s, biped.mass_estimate);
  declare_settings(s, biped.swing_foot);
  declare_settings(s, biped.drive_control);
  s.number("explain_limit_s", biped.explain_limit, "s",
           "time limit for each explanation of a violated plan, computed after the run; 0: no "
           "explanations",
           between(0.0, 3600.0));
  declare_renamed(s);
  declare_removed(s);
}

void declare_pictures(Settings& s, BipedSettings& biped) {
  s.flag("pictures", biped.pictures,
         "draw the pictures at the end (needs python3 with matplotlib)");
}

}  // namespace saltus::robots::walking
