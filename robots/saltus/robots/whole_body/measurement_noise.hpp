// White Gaussian noise on ideal measurements of the whole body.
#pragma once

#include <random>

#include "saltus/robots/whole_body/device_options.hpp"
#include "saltus/robots/whole_body/robot.hpp"

namespace saltus::robots {

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

}  // namespace saltus::robots
