// All settings of a biped in a closed loop, composed of the options of the modules.
#pragma once

#include "saltus/robots/walking/capture_point_controller.hpp"
#include "saltus/robots/walking/contact_settings.hpp"
#include "saltus/robots/walking/contacts.hpp"
#include "saltus/robots/walking/planner.hpp"
#include "saltus/robots/walking/plant_settings.hpp"
#include "saltus/robots/walking/push.hpp"
#include "saltus/robots/walking/robot_choice.hpp"
#include "saltus/robots/walking/step_logic.hpp"
#include "saltus/robots/whole_body/whole_body_settings.hpp"

namespace saltus::walking {

/// The problem's own planner ("mpc"), or the capture-point controller without prediction.
enum class ControllerChoice { mpc, capture_point };

/// All settings of a biped in a closed loop.
struct BipedSettings {
  std::string preset;   ///< name of a preset of settings, if the problem declares presets
  PlantSettings plant;  ///< simulated system
  RobotChoice robot;    ///< robot and its posture
  ControllerChoice controller = ControllerChoice::mpc;  ///< type of controller
  PlannerSettings planner;      ///< options of the model predictive controller
  CapturePointGains baseline;   ///< gains of the capture-point controller
  SceneSettings scene;          ///< stance and target of the CoM
  Step step;                    ///< time and place of steps
  Push push;                    ///< first push
  MorePushes more_pushes;       ///< further pushes
  ContactSettings contact;      ///< contacts of both feet
  WholeBodyControl control;     ///< whole-body controller
  bool pictures = true;         ///< draw pictures at the end
  double explain_limit = 10.0;  ///< time limit for explanations of unmet constraints, s; 0: none
};

/// Contact schedule known at the start: contacts of the scene, with capacity for the possible
/// steps.
Schedule first_contacts(const BipedSettings& settings, const Scene& scene);

}  // namespace saltus::walking
