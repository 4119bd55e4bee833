// Settings keys of a biped in a closed loop: each function binds keys to the fields of one option
// struct.
#pragma once

#include "saltus/robots/walking/biped_settings.hpp"

namespace saltus {
class Settings;
}

namespace saltus::robots::walking {

/// Declares all keys but `pictures`, the rules between option structs, and the removed keys of
/// version 0.2.
void declare_biped(Settings& settings, BipedSettings& biped);
/// Declares `pictures`.
void declare_pictures(Settings& settings, BipedSettings& biped);

/// Declares `plant`.
void declare_plant(Settings& settings, PlantSettings& plant);
/// Declares simulator.step_s.
void declare_step(Settings& settings, PlantSettings& plant);
/// Declares the rest of simulator.*, motor.*, drive.*, sensors, sensor.* and dart.*
void declare_settings(Settings& settings, PlantSettings& plant);

/// Declares control.period.
void declare_period(Settings& settings, WholeBodyController::Options& control);
/// Declares whole_body.* and momentum.*
void declare_settings(Settings& settings, WholeBodyController::Options& control);
/// Declares whole_body.stance_stiffness.
void declare_settings(Settings& settings, StanceFootOptions& stance);
/// Declares whole_body.estimate_support.
void declare_settings(Settings& settings, FootSupportOptions& support);
/// Declares whole_body.estimate_mass.
void declare_settings(Settings& settings, MassEstimateOptions& estimate);
/// Declares swing.*
void declare_settings(Settings& settings, SwingOptions& swing);
/// Declares drive.stiffness and drive.damping.
void declare_settings(Settings& settings, DriveController::Options& drive);
/// Declares sensor.*
void declare_settings(Settings& settings, SensorOptions& sensors, Estimator::Options& estimation);

/// Declares robot.urdf and robot.config.
void declare_settings(Settings& settings, RobotChoice& robot);
/// Declares model.*
void declare_mass_error(Settings& settings, RobotChoice& robot);
/// Declares `stance`.
void declare_stance(Settings& settings, SceneSettings& scene);
/// Declares `target`.
void declare_target(Settings& settings, SceneSettings& scene);

/// Declares push.impulse, direction, duration, start, shape.
void declare_settings(Settings& settings, Push& push);
/// Declares pushes and push.random.*
void declare_settings(Settings& settings, MorePushes& more, const Push& first);
/// Declares push.link and push.point, which have no effect on a model without links.
void declare_point_of_push(Settings& settings, Push& push);

/// Declares step.*
void declare_settings(Settings& settings, Step& step);
/// Declares `stepping`.
void declare_stepping(Settings& settings, Step& step);

/// Declares `solver`.
void declare_solver(Settings& settings, PlannerSettings& planner);
/// Declares mpc.* and solver_tolerance.
void declare_settings(Settings& settings, PlannerSettings& planner);
/// Declares contact.*
void declare_settings(Settings& settings, ContactSettings& contact);

}  // namespace saltus::robots::walking
