// A plant as its controllers see it: measured with noise, and obeying late.
#pragma once

#include <memory>
#include <random>
#include <vector>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus {

/// Standard deviations of white Gaussian noise, drawn anew in every step of the engine. Positions
/// are not filtered. Velocities are not differences of the noisy positions: their noise is what an
/// estimator leaves, and is given by itself.
struct MeasurementNoise {
  double position = 0.0;          ///< m, of the base's origin, each axis
  double angle = 0.0;             ///< rad, of the base's orientation (each axis) and of every joint
  double velocity = 0.0;          ///< m/s, of the base's origin, each axis
  double angular_velocity = 0.0;  ///< rad/s, of the base (each axis) and of every joint
  double force = 0.0;             ///< relative, of every entry of the wrench of a foot
  int seed = 1;                   ///< the same numbers for the same seed

  /// Whether nothing is added.
  bool is_zero() const {
    return position == 0.0 && angle == 0.0 && velocity == 0.0 && angular_velocity == 0.0 &&
           force == 0.0;
  }
};

/// state() and contact() are measurements; torques act `delay` calls of set_torques() later, up to
/// then the first ones do. Without noise and delay it changes nothing. After construction only
/// reset() allocates.
class MeasuredPlant final : public PlantAround {
 public:
  /// Throws DefinitionError if a deviation is negative or not finite, or the delay is negative.
  MeasuredPlant(std::unique_ptr<Plant> plant, const MeasurementNoise& noise, int delay);

  /// What is really so.
  const Plant& truth() const { return *plant_; }

  void reset(const WholeBodyState& state) override;
  void set_torques(const VectorXd& torques) override;
  void step() override;

  const WholeBodyState& state() const override { return state_; }
  const FootContact& contact(Side side) const override {
    return contacts_[side == Side::left ? 0 : 1];
  }

 private:
  void measure();
  double draw(double deviation);

  MeasurementNoise noise_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
  WholeBodyState state_;
  FootContact contacts_[2];
  std::vector<VectorXd> waiting_;  // a ring: torques that do not act yet
  std::size_t next_ = 0;           // the one that acts next
  bool is_first_ = true;
};

}  // namespace saltus
