// The estimators behind make_ideal_estimator() and make_sensor_estimator().
#pragma once

#include "saltus/robots/whole_body/base_estimator.hpp"
#include "saltus/robots/whole_body/estimator.hpp"
#include "saltus/robots/whole_body/joint_velocity_filter.hpp"
#include "saltus/robots/whole_body/sole_kinematics.hpp"

namespace saltus::robots {

/// Passes the state of ideal sensors through.
class IdealEstimator final : public Estimator {
 public:
  void start(const WholeBodyState&, const Robot::Readings& readings) override { update(readings); }
  /// Throws DefinitionError for readings without ideal ones.
  void update(const Robot::Readings& readings) override;
  void pin(Side) override {}
  const WholeBodyEstimate& estimate() const override { return estimate_; }

 private:
  WholeBodyEstimate estimate_;
};

/// Estimates the state from real sensors. Joint positions are the measured ones, joint velocities
/// come from JointVelocityFilter. BaseEstimator gives pose and velocity of the base. Its angular
/// velocity is the reading of the gyroscope minus the bias.
class SensorEstimator final : public Estimator {
 public:
  /// `robot` is the geometry that the controllers use, `pin` the first pin foot, and `period` the
  /// time between two readings, s. Noise, rates and delays of `sensors` are used; its seed draws
  /// the error of the first estimate. Throws DefinitionError for options that are negative or not
  /// finite.
  SensorEstimator(const FloatingRobot& robot, Side pin, const SensorOptions& sensors,
                  const Estimator::Options& options, double period);

  void start(const WholeBodyState& state, const Robot::Readings& readings) override;
  void update(const Robot::Readings& readings) override;
  void pin(Side foot) override;
  const WholeBodyEstimate& estimate() const override { return estimate_; }

  /// Filter of the base.
  const BaseEstimator& base() const { return base_; }

 private:
  void read_soles(const Robot::Readings& readings);
  void publish(const Robot::Readings& readings);

  double period_;
  double certain_stand_;  // s: time after the start in which the pin is known to stand
  Side first_pin_, pin_;  // pin at the start, and current pin
  double start_time_ = 0.0, time_ = 0.0;  // times of the first and the last readings, s
  Estimator::Options options_;
  double leg_variance_;  // variance of a joint position in leg kinematics, rad^2
  std::uint64_t seed_;
  SoleKinematics soles_[2];
  SoleReading soles_read_[2];
  FootRectangle resting_[2];  // area of the centre of pressure in which a sole counts as resting
  JointVelocityFilter velocities_;
  BaseEstimator base_;
  WholeBodyEstimate estimate_;
};

}  // namespace saltus::robots
