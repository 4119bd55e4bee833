// All options of a biped in a closed loop, put together from the option structs of the modules.
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

/// All settings of a biped's closed loop.
struct BipedSettings {
  std::string preset;   ///< of the settings, by name; of a problem that declares presets
  PlantSettings plant;  ///< who answers the controller
  RobotChoice robot;    ///< which robot, in which posture
  ControllerChoice controller = ControllerChoice::mpc;  ///< who holds the robot
  PlannerSettings planner;                              ///< of the model predictive controller
  CapturePointGains baseline;                           ///< of the capture point controller
  SceneSettings scene;                                  ///< where the robot shall come to rest
  Step step;                                            ///< when and where a foot is put
  Push push;                                            ///< the first one
  MorePushes more_pushes;                               ///< those after it
  ContactSettings contact;                              ///< both feet
  WholeBodyControl control;                             ///< of the whole body
  bool pictures = true;                                 ///< draw them at the end
  double explain_limit = 10.0;                          ///< for what could not be met, s; 0: none
};

/// Which feet stand when, as far as it is known when the run begins: those of the scene. With room
/// for the steps that may come.
Schedule first_contacts(const BipedSettings& settings, const Scene& scene);

}  // namespace saltus::walking
