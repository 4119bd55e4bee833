// Options of the simulated system: the centroidal model, or the whole body in an engine, with
// disturbances.
#pragma once

#include "saltus/robots/dart/dart_plant.hpp"
#include "saltus/robots/whole_body/measurement_noise.hpp"
#include "saltus/robots/whole_body/motors.hpp"
#include "saltus/robots/whole_body/sensor_options.hpp"

namespace saltus::walking {

/// Simulated system and engine.
enum class PlantChoice { centroidal, dart, mujoco };
/// Input of the controllers: the state with `noise`, or an estimate from simulated sensors.
enum class SensorChoice { ideal, measured };

/// Options of the simulation. All but `choice` apply only to the whole body.
struct PlantSettings {
  PlantChoice choice = PlantChoice::centroidal;  ///< simulated system and engine
  /// Engine and ground. The controllers do not know the step in the ground. It begins `ground_edge`
  /// (m) from the stance sole, on the side of the swing foot. The lifted swing foot extends to
  /// 0.17 m.
  DartOptions engine{{.ground_edge = 0.18}};
  int delay_ticks = 0;                         ///< delay of the torques, control periods
  MotorOptions motors;                         ///< lag and rate limit of the torques
  SensorChoice sensors = SensorChoice::ideal;  ///< ideal or measured
  MeasurementNoise noise;                      ///< noise of ideal sensors
  SensorOptions sensor;                        ///< options of simulated sensors
  EstimationOptions estimation;                ///< estimation from simulated sensors

  /// True if a whole body is simulated.
  bool is_whole_body() const { return choice != PlantChoice::centroidal; }
};

}  // namespace saltus::walking
