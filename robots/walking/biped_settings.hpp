// What any biped in a closed loop can be told, put together from the modules that own the settings.
#pragma once

#include "saltus/robots/walking/capture_point_controller.hpp"
#include "saltus/robots/walking/contact_settings.hpp"
#include "saltus/robots/walking/contacts.hpp"
#include "saltus/robots/walking/planner.hpp"
#include "saltus/robots/walking/plant_settings.hpp"
#include "saltus/robots/walking/push.hpp"
#include "saltus/robots/walking/robot_choice.hpp"
#include "saltus/robots/walking/step_logic.hpp"

namespace saltus::walking {

/// The problem's own planner ("mpc"), or the capture-point controller without prediction.
enum class ControllerChoice { mpc, capture_point };

struct BipedSettings {
  std::string preset;  ///< of the settings, by name; of a problem that declares presets
  PlantSettings plant;
  RobotChoice robot;
  ControllerChoice controller = ControllerChoice::mpc;
  PlannerSettings planner;
  CapturePointGains baseline;
  SceneSettings scene;
  Step step;
  Push push;
  MorePushes more_pushes;
  ContactSettings contact;  ///< both feet
  WholeBodyControl control;
  bool pictures = true;
};

/// Which feet stand when, as far as it is known when the run begins: those of the scene. With room
/// for the steps that may come.
Schedule first_contacts(const BipedSettings& settings, const Scene& scene);

/// All keys but `pictures`, each declared by its module, and the rules between modules.
void declare_biped(Settings& settings, BipedSettings& biped);
/// `pictures`.
void declare_pictures(Settings& settings, BipedSettings& biped);

}  // namespace saltus::walking
