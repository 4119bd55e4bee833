// What is simulated: the centroidal model, or the whole body in an engine, with its disturbances.
#pragma once

#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/whole_body/measurement_noise.hpp"
#include "saltus/robots/whole_body/motors.hpp"
#include "saltus/robots/whole_body/sensor_options.hpp"

namespace saltus::walking {

/// Centroidal model or whole body, and in which engine.
enum class PlantChoice { centroidal, dart, mujoco };
/// What the controllers get: the state itself with `noise`, or an estimate from the robot's
/// sensors.
enum class SensorChoice { ideal, measured };

/// All but `choice` concerns the whole body only.
struct PlantSettings {
  PlantChoice choice = PlantChoice::centroidal;  ///< which one
  /// Engine and ground. The controllers do not know of the step of the ground: beyond `ground_edge`
  /// (m) from the stance sole, on the swing foot's side. The lifted swing foot reaches to 0.17 m.
  DartOptions engine{{.ground_edge = 0.18}};
  int delay_ticks = 0;                         ///< delay of the torques, control periods
  MotorOptions motors;                         ///< lag and rate of the torques
  SensorChoice sensors = SensorChoice::ideal;  ///< ideal or measured
  MeasurementNoise noise;                      ///< of ideal sensors
  SensorOptions sensor;                        ///< of measured ones
  EstimationOptions estimation;                ///< of the state from measured ones

  /// True if a whole body is simulated.
  bool is_whole_body() const { return choice != PlantChoice::centroidal; }
};

}  // namespace saltus::walking
