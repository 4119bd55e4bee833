// Motors that follow the torques asked of them with a lag.
#pragma once

#include <memory>

#include "saltus/robots/whole_body/plant.hpp"

namespace saltus {

/// First-order lag, then a limit on the rate of change; all joints alike.
struct MotorOptions {
  double bandwidth = 0.0;    ///< Hz, at which the lag takes off 3 dB; 0: no lag
  double torque_rate = 0.0;  ///< largest, Nm/s; 0: no limit

  /// Whether torques act at once and as asked.
  bool is_ideal() const { return bandwidth == 0.0 && torque_rate == 0.0; }
};

/// The plant driven by such motors; after a reset the first torques act at once. `step` is the
/// engine's, s. Throws DefinitionError for options below zero or not finite, or a step that is not
/// positive.
std::unique_ptr<Plant> with_motors(std::unique_ptr<Plant> plant, const MotorOptions& options,
                                   double step);

}  // namespace saltus
