// White Gaussian noise on ideal measurements of the whole body.
#pragma once

#include <random>

#include "saltus/robots/whole_body/whole_body_state.hpp"

namespace saltus {

/// Standard deviations of the noise, drawn anew in every step of the engine. Positions are not
/// filtered. Velocities have separate noise, which represents the error of an estimator. It is not
/// the noise of a difference of positions.
struct MeasurementNoise {
  double position = 0.0;          ///< m, of the base's origin, each axis
  double angle = 0.0;             ///< rad, of the base's orientation (each axis) and of every joint
  double velocity = 0.0;          ///< m/s, of the base's origin, each axis
  double angular_velocity = 0.0;  ///< rad/s, of the base (each axis) and of every joint
  double force = 0.0;             ///< relative, of every entry of the wrench of a foot
  int seed = 1;                   ///< The same seed gives the same numbers.

  /// True if no noise is added.
  bool is_zero() const {
    return position == 0.0 && angle == 0.0 && velocity == 0.0 && angular_velocity == 0.0 &&
           force == 0.0;
  }
};

/// Draws the noise and adds it. Does not allocate.
class NoiseSource {
 public:
  /// Throws DefinitionError if a deviation is negative or not finite.
  explicit NoiseSource(const MeasurementNoise& noise);

  /// Restarts the sequence of random numbers.
  void reset();
  /// Adds noise to a state and its contacts.
  void disturb(WholeBodyEstimate& measured);

 private:
  double draw(double deviation) { return deviation * normal_(random_); }

  MeasurementNoise noise_;
  std::mt19937 random_;
  std::normal_distribution<double> normal_;
};

}  // namespace saltus
