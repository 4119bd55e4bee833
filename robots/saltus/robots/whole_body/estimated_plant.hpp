// A plant as its controllers see it through the robot's own sensors: state() and contact() are what
// an estimator makes of them.
#pragma once

#include <memory>

#include "saltus/robots/whole_body/base_estimator.hpp"
#include "saltus/robots/whole_body/joint_velocity_filter.hpp"
#include "saltus/robots/whole_body/sensors.hpp"

namespace saltus {

/// Positions of joints as measured, their velocities by JointVelocityFilter; pose and velocity of
/// the base by BaseEstimator, its angular velocity by the gyroscope without its bias. The world is
/// where the pin (a stance foot) stands. After construction only reset() allocates.
class EstimatedPlant final : public PlantAround {
 public:
  /// Sees `plant`, whose engine takes steps of `step` (s). `robot`: the geometry that the
  /// controllers know. Throws DefinitionError for options that make no sense.
  EstimatedPlant(std::unique_ptr<Plant> plant, const FloatingRobot& robot, Side pin,
                 const SensorOptions& sensors, const EstimationOptions& options, double step);

  void reset(const WholeBodyState& state) override;
  void step() override;

  const WholeBodyState& state() const override { return state_; }
  const FootContact& contact(Side side) const override {
    return contacts_[side == Side::left ? 0 : 1];
  }

  /// What it knows of the base.
  const BaseEstimator& base() const { return base_; }
  /// The world is where this foot, which stands, does from now on.
  void pin(Side foot);

 private:
  void read_soles();
  void publish();

  double step_;
  double certain_stand_;  // s: until then the pin is known to stand
  Side first_pin_, pin_;  // where the robot stands at a reset, and now
  EstimationOptions options_;
  Sensors sensors_;
  double leg_variance_;  // of a joint, rad^2
  Random random_;
  std::uint64_t seed_;
  SoleKinematics soles_[2];
  SoleReading readings_[2];
  FootRectangle resting_[2];  // where the centre of pressure of a sole that rests lies
  JointVelocityFilter velocities_;
  BaseEstimator base_;
  WholeBodyState state_;
  FootContact contacts_[2];
};

}  // namespace saltus
