#include "problems/biped/keys/keys.hpp"

#include <fmt/format.h>

#include <cmath>
#include <string>

#include "saltus/app/settings.hpp"

namespace saltus::walking {
namespace {

bool is_multiple(double whole, double part) {
  constexpr double rounding = 1e-6;  // of decimals that have no exact binary form
  const double ratio = whole / part;
  return ratio > 0.5 && std::abs(ratio - std::round(ratio)) < rounding * ratio;
}

// The loop on the whole body counts steps of the engine: every period is a whole number of them.
std::string clock_complaint(const BipedSettings& c) {
  if (c.plant.choice == PlantChoice::centroidal) return "";
  if (!is_multiple(c.control.period, c.plant.step))
    return fmt::format("control.period ({} s) must be a whole multiple of simulator.step ({} s)",
                       c.control.period, c.plant.step);
  if (!is_multiple(c.planner.step, c.control.period))
    return fmt::format("mpc.step ({} s) must be a whole multiple of control.period ({} s)",
                       c.planner.step, c.control.period);
  return "";
}

}  // namespace

void declare_biped(Settings& s, BipedSettings& biped) {
  declare_plant(s, biped.plant);
  declare_settings(s, biped.robot);
  s.choice<ControllerChoice>(
      "controller", biped.controller,
      {{"mpc", ControllerChoice::mpc}, {"capture_point", ControllerChoice::capture_point}},
      "receding horizon, or the capture-point controller without prediction");
  declare_solver(s, biped.planner);
  declare_stance(s, biped.scene);
  declare_stepping(s, biped.step);
  declare_mass_error(s, biped.robot);
  declare_target(s, biped.scene);
  declare_settings(s, biped.push);
  declare_settings(s, biped.more_pushes, biped.push);
  declare_settings(s, biped.step);
  declare_settings(s, biped.planner);
  declare_settings(s, biped.baseline);
  declare_settings(s, biped.contact);
  declare_point_of_push(s, biped.push);
  declare_period(s, biped.control);
  declare_step(s, biped.plant);
  s.rule({"control.period", "mpc.step", "simulator.step"},
         [&biped] { return clock_complaint(biped); });
  declare_settings(s, biped.plant);
  declare_settings(s, biped.control);
  s.number("explain_limit", biped.explain_limit, "s",
           "for each explanation of what planners could not keep to, when the run is over; 0: none "
           "is looked for",
           between(0.0, 3600.0));
}

void declare_pictures(Settings& s, BipedSettings& biped) {
  s.flag("pictures", biped.pictures,
         "draw the pictures at the end (needs python3 with matplotlib)");
}

}  // namespace saltus::walking
