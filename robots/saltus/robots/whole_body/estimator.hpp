// Estimators: from sensor readings to the state of the whole body and its contacts.
#pragma once

#include <memory>

#include "saltus/robots/whole_body/device_options.hpp"
#include "saltus/robots/whole_body/floating_robot.hpp"
#include "saltus/robots/whole_body/robot.hpp"

namespace saltus::robots {

/// Computes an estimate from readings. Only start() allocates after construction.
class Estimator {
 public:
  /// Options of the estimator.
  struct Options {
    double velocity_lag = 0.0015;  ///< s, lag of the joint velocities, without the encoder delay
    double standing_force = 40.0;  ///< N, vertical: contact begins above this load and ends at
                                   ///< half of it
    /// Random walk of the foot that defines the world, while it stands on an edge, m/s per
    /// sqrt(Hz). 0: the foot does not move.
    double rocking_walk = 0.0;
    double initial_tilt = 0.01;  ///< rad, standard deviation of the initial roll and pitch
  };

  virtual ~Estimator() = default;

  /// Starts at rest in `state`, which may differ from the readings.
  virtual void start(const WholeBodyState& state, const Robot::Readings& readings) = 0;
  /// Processes readings once, in the order of their times. Readings that are not newer than the
  /// last ones have no effect.
  virtual void update(const Robot::Readings& readings) = 0;
  /// Sets the foot whose position defines the world from now on. It must stand.
  virtual void pin(Side foot) = 0;
  /// Estimate after the last readings.
  virtual const WholeBodyEstimate& estimate() const = 0;
};

/// Creates an estimator that passes the state of ideal sensors through. Its update() throws
/// DefinitionError for readings without ideal ones.
std::unique_ptr<Estimator> make_ideal_estimator();

/// Creates an estimator for real sensors. Joint positions are the measured ones, joint velocities
/// come from a filter of them. A Kalman filter gives pose and velocity of the base. Its angular
/// velocity is the reading of the gyroscope minus the bias.
///
/// `robot` is the geometry that the controllers use, `pin` the first foot whose position defines
/// the world, and `period` the time between two readings, s. Noise, rates and delays of `sensors`
/// are used; its seed draws the error of the first estimate. Throws DefinitionError for options
/// that are negative or not finite.
std::unique_ptr<Estimator> make_sensor_estimator(const FloatingRobot& robot, Side pin,
                                                 const SensorOptions& sensors,
                                                 const Estimator::Options& options, double period);

}  // namespace saltus::robots
