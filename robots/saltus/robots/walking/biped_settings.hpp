// All settings of a biped in a closed loop: robot, simulated system, pushes, and the options of the
// modules.
#pragma once

#include <span>
#include <string>

#include "saltus/ocp/pulse.hpp"
#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/walking/contacts.hpp"
#include "saltus/robots/walking/planner.hpp"
#include "saltus/robots/walking/scene.hpp"
#include "saltus/robots/walking/step_planner.hpp"
#include "saltus/robots/whole_body/corrected_model.hpp"
#include "saltus/robots/whole_body/device_options.hpp"
#include "saltus/robots/whole_body/estimator.hpp"
#include "saltus/robots/whole_body/whole_body_controller.hpp"

namespace saltus::robots::walking {

/// Options of the simulation. All but `choice` apply only to the whole body.
struct PlantSettings {
  /// Simulated system and engine.
  enum class Choice { centroidal, dart, mujoco };

  /// Input of the controllers: the state with `noise`, or an estimate from simulated sensors.
  enum class Sensors { ideal, measured };

  Choice choice = Choice::centroidal;  ///< simulated system and engine
  /// Engine and ground. The controllers assume level ground. The edge of the ground is on the side
  /// of the swing foot; only its distance from the stance sole counts here. The lifted swing foot
  /// extends to 0.17 m.
  DartOptions engine{{.ground = {.edge = 0.18}}};
  int delay_ticks = 0;               ///< delay of the torques, control periods
  MotorOptions motors;               ///< lag and rate limit of the torques
  DriveFactors drives;               ///< drives of the simulated robot
  Sensors sensors = Sensors::ideal;  ///< ideal or measured
  MeasurementNoise noise;            ///< noise of ideal sensors
  SensorOptions sensor;              ///< options of simulated sensors
  Estimator::Options estimation;     ///< estimation from simulated sensors

  /// True if a whole body is simulated.
  bool is_whole_body() const { return choice != Choice::centroidal; }
};
/// Deprecated name.
using PlantChoice [[deprecated("use PlantSettings::Choice; removed in 0.4")]] =
    PlantSettings::Choice;

/// Files of the robot.
struct RobotChoice {
  std::string urdf;  ///< empty: the data of robots/icub, or those of `file`
  std::string file;  ///< names, postures and limits; empty: those of iCub
  /// Relative error of all masses and inertias in the controllers' model. The simulated robot is
  /// exact.
  double mass_error = 0.0;
  /// For the whole body: error of the CoM in the controllers' model, m, axes of the base.
  Vec<double, 3> com_error = Vec<double, 3>::Zero();
  DriveFactors drives;  ///< drives of the controllers' model
};

/// A force on the robot for a limited time. Its direction is in world axes and need not be a unit
/// vector.
struct Push : Pulse {
  /// Towards the right, in the middle of the chest.
  Push() : Pulse{7.0, Vec<double, 3>(0.0, -1.0, 0.0), 2.4, 0.1} {}

  /// For the whole body: pushed link of the URDF, and the point in its frame, m. The centroidal
  /// model is pushed at its CoM.
  std::string link = "chest";
  Vec<double, 3> point{0.0, 0.0, 0.0};  ///< in the frame of the pushed link, m
};

/// Deprecated name.
using PushShape [[deprecated("use saltus::PulseShape; removed in 0.4")]] = PulseShape;
/// Deprecated name.
[[deprecated("use Pulse::fraction; removed in 0.4")]] inline double impulse_fraction(
    const Push& push, double t) {
  return push.fraction(t);
}
/// Deprecated. Mean force of a push with a direction of any length, N.
[[deprecated("use Pulse::mean; removed in 0.4")]] inline Vec<double, 3> mean_push_force(Push push,
                                                                                        double from,
                                                                                        double to) {
  push.direction.normalize();
  return push.mean(from, to);
}
/// Deprecated. Sum of the mean forces of pushes with directions of any length, N.
[[deprecated("use Pulse::mean; removed in 0.4")]] inline Vec<double, 3> total_push_force(
    std::span<const Push> pushes, double from, double to) {
  Vec<double, 3> force = Vec<double, 3>::Zero();
  for (Push push : pushes) {
    push.direction.normalize();
    force += push.mean(from, to);
  }
  return force;
}

/// Further pushes, with the shape and point of the first one.
struct MorePushes {
  /// "TIME IMPULSE ANGLE [DURATION]; ...": s, N s, degrees (0 forward, 90 to the left), s.
  std::string list;
  /// Mean rate of random pushes in random horizontal directions; 0: none.
  double rate = 0.0;                 ///< Hz
  double until = 60.0;               ///< time at which the last of them is over, s
  Vec<double, 2> impulse{3.0, 8.0};  ///< range, N s
  double apart = 4.0;                ///< smallest time between two starts, s
  int seed = 1;                      ///< seed of the random pushes
};

/// All settings of a biped in a closed loop.
struct BipedSettings {
  /// The problem's own planner ("mpc"), or the capture-point controller without prediction.
  enum class Controller { mpc, capture_point };

  std::string preset;   ///< name of a preset of settings, if the problem declares presets
  PlantSettings plant;  ///< simulated system
  RobotChoice robot;    ///< robot and its posture
  Controller controller = Controller::mpc;  ///< type of controller
  PlannerSettings planner;                  ///< options of the model predictive controller
  CapturePointGains baseline;               ///< gains of the capture-point controller
  SceneSettings scene;                      ///< stance and target of the CoM
  Step step;                                ///< time and place of steps
  Push push;                                ///< first push
  MorePushes more_pushes;                   ///< further pushes
  ContactSettings contact;                  ///< contacts of both feet
  WholeBodyController::Options control;     ///< whole-body controller
  DriveController::Options drive_control;   ///< commands for the drives
  StanceFootOptions stance_foot;            ///< hold of standing feet
  FootSupportOptions foot_support;          ///< estimate of the ground below them
  MassEstimateOptions mass_estimate;        ///< estimate of mass and CoM
  SwingOptions swing_foot;                  ///< motion of the swing foot
  bool pictures = true;                     ///< draw pictures at the end
  double explain_limit = 10.0;  ///< time limit for explanations of unmet constraints, s; 0: none
};
/// Deprecated name.
using ControllerChoice [[deprecated("use BipedSettings::Controller; removed in 0.4")]] =
    BipedSettings::Controller;

/// Contact schedule known at the start: contacts of the scene, with capacity for the possible
/// steps.
Schedule first_contacts(const BipedSettings& settings, const Scene& scene);

}  // namespace saltus::robots::walking
