// Estimators: from sensor readings to the state of the whole body and its contacts.
#pragma once

#include "saltus/robots/whole_body/base_estimator.hpp"
#include "saltus/robots/whole_body/joint_velocity_filter.hpp"
#include "saltus/robots/whole_body/robot.hpp"
#include "saltus/robots/whole_body/sensor_options.hpp"
#include "saltus/robots/whole_body/sole_kinematics.hpp"

namespace saltus {

/// From readings to an estimate. After construction only start() allocates.
class Estimator {
 public:
  virtual ~Estimator() = default;

  /// Starts at rest in `state`, from which readings may differ.
  virtual void start(const WholeBodyState& state, const SensorReadings& readings) = 0;
  /// Once for all readings, in the order of their times. Readings no later than the last ones have
  /// no effect.
  virtual void update(const SensorReadings& readings) = 0;
  /// The foot whose place defines the world from now on. It must stand.
  virtual void pin(Side foot) = 0;
  /// What is known after the last readings.
  virtual const WholeBodyEstimate& estimate() const = 0;
};

/// Passes on the state of ideal sensors.
class IdealEstimator final : public Estimator {
 public:
  void start(const WholeBodyState&, const SensorReadings& readings) override { update(readings); }
  /// Throws DefinitionError for readings without ideal ones.
  void update(const SensorReadings& readings) override;
  void pin(Side) override {}
  const WholeBodyEstimate& estimate() const override { return estimate_; }

 private:
  WholeBodyEstimate estimate_;
};

/// Joint positions as measured, their velocities by JointVelocityFilter; pose and velocity of the
/// base by BaseEstimator, its angular velocity from the gyroscope without its bias.
class SensorEstimator final : public Estimator {
 public:
  /// `robot`: the geometry that the controllers know; `pin`: the foot on which it starts; `period`
  /// between two readings, s. Noise, rates and delays of `sensors` are used, their seed for the
  /// error of the first estimate. Throws DefinitionError for options that are not finite or below
  /// zero.
  SensorEstimator(const FloatingRobot& robot, Side pin, const SensorOptions& sensors,
                  const EstimationOptions& options, double period);

  void start(const WholeBodyState& state, const SensorReadings& readings) override;
  void update(const SensorReadings& readings) override;
  void pin(Side foot) override;
  const WholeBodyEstimate& estimate() const override { return estimate_; }

  /// Filter of the base.
  const BaseEstimator& base() const { return base_; }

 private:
  void read_soles(const SensorReadings& readings);
  void publish(const SensorReadings& readings);

  double period_;
  double certain_stand_;  // s: until then the pin is known to stand
  Side first_pin_, pin_;  // where the robot stands at the start, and now
  double time_ = 0.0;     // of the last readings, s
  EstimationOptions options_;
  double leg_variance_;  // of a joint, rad^2
  std::uint64_t seed_;
  SoleKinematics soles_[2];
  SoleReading soles_read_[2];
  FootRectangle resting_[2];  // where the centre of pressure of a sole that rests lies
  JointVelocityFilter velocities_;
  BaseEstimator base_;
  WholeBodyEstimate estimate_;
};

}  // namespace saltus
