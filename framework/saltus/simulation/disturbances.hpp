// Differences between a plant and the model of its controller: forces, noise, delays.
#pragma once

#include <cstdint>
#include <functional>

#include "saltus/core/types.hpp"

namespace saltus {

/// All disturbances are off by default. The same seed gives the same run on every machine. For a
/// mismatch of parameters, give the plant its own parameters.
struct Disturbances {
  /// Disturbance added to the input of the plant. Called at the start of every piece of the input
  /// with the true state; writes `added` (nu), which is zero on entry.
  std::function<void(double t, const VectorRef& state, VectorOut added)> input = {};
  /// Disturbance of the state at the start of every tick, before the measurement; writes `added`
  /// (nx).
  std::function<void(double t, const VectorRef& state, VectorOut added)> state = {};
  /// Standard deviations (nx) of white Gaussian noise; empty: none.
  VectorXd state_noise = {};        ///< added to the state at the start of every tick
  VectorXd measurement_noise = {};  ///< added to the measured state only
  std::uint64_t seed = 1;           ///< seed of the noise
  /// Delay of the measured state in seconds; a multiple of the control period.
  double measurement_delay = 0.0;
  /// Delay of the input in seconds. Until then `first_input` is applied.
  double input_delay = 0.0;
  VectorXd first_input = {};  ///< input before the first one arrives (nu); empty: zero
};

}  // namespace saltus
