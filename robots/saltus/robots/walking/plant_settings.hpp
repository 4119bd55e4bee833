// What is pushed: the centroidal model, or the whole body in a simulator, with what disturbs it.
#pragma once

#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/whole_body/motors.hpp"
#include "saltus/robots/whole_body/whole_body_settings.hpp"

namespace saltus::walking {

/// Centroidal model or whole body, and in which simulator.
enum class PlantChoice { centroidal, dart, mujoco };
/// What the controllers see: the truth, but for `noise`; or an estimate from the robot's sensors.
enum class SensorChoice { ideal, measured };

/// All but `choice` concerns the whole body only.
struct PlantSettings {
  PlantChoice choice = PlantChoice::centroidal;  ///< which one
  double step = 0.001;                           ///< s
  double friction = 1.0;                         ///< of the ground
  /// Unknown to the controllers: beyond this distance from the stance sole, on the swing foot's
  /// side, the ground is higher (or lower, < 0), m. The lifted swing foot reaches to 0.17 m.
  double ground_step = 0.0, ground_edge = 0.18;
  double joint_friction = 0.0;                 ///< viscous, Nm s/rad
  int delay_ticks = 0;                         ///< periods of control by which the torques are late
  MotorOptions motors;                         ///< lag and rate of the torques
  SensorChoice sensors = SensorChoice::ideal;  ///< ideal or measured
  MeasurementNoise noise;                      ///< of what the controllers see with ideal sensors
  SensorOptions sensor;                        ///< this and the next: with measured ones
  EstimationOptions estimation;                ///< of the base from measured senses
  DartCollision collision = DartCollision::bullet;  ///< DART's detector of collisions
  DartLcp lcp = DartLcp::dantzig;                   ///< DART's solver of contact forces
  DartFriction cone = DartFriction::box;            ///< DART's shape of the friction cone

  /// Whether a whole body is simulated.
  bool is_whole_body() const { return choice != PlantChoice::centroidal; }
};

}  // namespace saltus::walking
