// Settings keys of a biped in closed loop: each function binds keys to the fields of one option
// struct.
#pragma once

#include "saltus/robots/walking/biped_settings.hpp"

namespace saltus {
class Settings;
}

namespace saltus::walking {

/// All keys but `pictures`, the rules between option structs, and the keys of 0.2 that are gone.
void declare_biped(Settings& settings, BipedSettings& biped);
/// `pictures`.
void declare_pictures(Settings& settings, BipedSettings& biped);

/// `plant`.
void declare_plant(Settings& settings, PlantSettings& plant);
/// simulator.step.
void declare_step(Settings& settings, PlantSettings& plant);
/// The rest of simulator.*, motor.*, sensors, sensor.* and dart.*
void declare_settings(Settings& settings, PlantSettings& plant);

/// control.period.
void declare_period(Settings& settings, WholeBodyControl& control);
/// whole_body.* and momentum.*
void declare_settings(Settings& settings, WholeBodyControl& control);
/// sensor.*
void declare_settings(Settings& settings, SensorOptions& sensors, EstimationOptions& estimation);

/// robot.urdf and robot.config.
void declare_settings(Settings& settings, RobotChoice& robot);
/// model.mass_error.
void declare_mass_error(Settings& settings, RobotChoice& robot);
/// `stance`.
void declare_stance(Settings& settings, SceneSettings& scene);
/// `target`.
void declare_target(Settings& settings, SceneSettings& scene);

/// push.impulse, direction, duration, start, shape.
void declare_settings(Settings& settings, Push& push);
/// pushes and push.random.*
void declare_settings(Settings& settings, MorePushes& more, const Push& first);
/// push.link and push.point, which have no effect on a model without links.
void declare_point_of_push(Settings& settings, Push& push);

/// step.*
void declare_settings(Settings& settings, Step& step);
/// `stepping`.
void declare_stepping(Settings& settings, Step& step);

/// `solver`.
void declare_solver(Settings& settings, PlannerSettings& planner);
/// mpc.* and solver_tolerance.
void declare_settings(Settings& settings, PlannerSettings& planner);
/// contact.*
void declare_settings(Settings& settings, ContactSettings& contact);

}  // namespace saltus::walking
