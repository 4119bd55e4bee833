#include "problems/biped/keys/keys.hpp"

#include "saltus/app/settings.hpp"

namespace saltus::robots::walking {

void declare_stance(Settings& s, SceneSettings& scene) {
  s.choice<Stance>("stance", scene.stance,
                   {{"left", Stance::left}, {"right", Stance::right}, {"both", Stance::both}},
                   "stance foot at the start, with the other foot in the air; or both feet");
  s.text("posture", scene.posture,
         "end of the name of the posture at the start, such as bent; empty: the first posture with "
         "this stance");
}

void declare_target(Settings& s, SceneSettings& scene) {
  s.choice<SceneSettings::Target>("target", scene.target,
                                  {{"sole_midpoint", SceneSettings::Target::sole_midpoint},
                                   {"centroid", SceneSettings::Target::centroid}},
                                  "place where the CoM comes to rest after the step");
}

void declare_settings(Settings& s, RobotChoice& robot) {
  s.text("robot.urdf", robot.urdf,
         "URDF of the robot; empty: the official model of iCub if it was downloaded, otherwise the "
         "data that come with the program");
  s.alias("urdf", "robot.urdf");
  s.text("robot.config", robot.file,
         "file with the soles, base, joints, limits and postures of the robot (robots/README.md); "
         "empty: iCub's");
}

void declare_mass_error(Settings& s, RobotChoice& robot) {
  s.number("model.mass_error", robot.mass_error, "",
           "relative error of all masses and inertias in the controllers' model",
           between(-0.5, 1.0));
  s.vector("model.com_error", robot.com_error, "m",
           "whole body: error of the CoM in the controllers' model, in the axes of the base link",
           between(-0.1, 0.1));
  s.number("model.rotor_inertia", robot.drives.rotor_inertia, "",
           "rotor inertia in the controllers' model, as a multiple of that in the robot's file",
           between(0.0, 10.0));
  s.number("model.friction", robot.drives.friction, "",
           "friction of the drives that the controllers compensate, as a multiple of that in the "
           "robot's file",
           between(0.0, 10.0));
}

}  // namespace saltus::robots::walking
