// What stands between a controller and the plant of its model: forces, noise, delays.
#pragma once

#include <cstdint>
#include <functional>

#include "saltus/core/random.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

/// Nothing happens unless it is said. The same seed gives the same run on every machine.
/// (A mismatch of parameters is a matter of the plant: it is made with parameters of its own.)
struct Disturbances {
  /// Added to the input that reaches the plant; asked at the start of every piece of the input with
  /// the true state, fills `added` (nu), which is zero before.
  std::function<void(double t, const VectorRef& state, VectorOut added)> input = {};
  /// Added to the state at the start of every tick, before it is measured; fills `added` (nx).
  std::function<void(double t, const VectorRef& state, VectorOut added)> state = {};
  /// Standard deviations (nx) of white Gaussian noise; empty: none.
  VectorXd state_noise = {};        ///< added to the state itself at the start of every tick
  VectorXd measurement_noise = {};  ///< added to what the controller sees only
  std::uint64_t seed = 1;           ///< the same numbers for the same seed
  /// The controller sees the state of so long ago, s; a multiple of its period.
  double measurement_delay = 0.0;
  /// The plant obeys so late, s; until then `first_input` (nu; empty: zero) is in force.
  double input_delay = 0.0;
  VectorXd first_input = {};  ///< what acts before the first one arrives; empty: zeros
};

/// White Gaussian noise that does not depend on the standard library: Box and Muller's formula
/// over the Mersenne twister.
class GaussianNoise {
 public:
  /// The same numbers for the same seed.
  explicit GaussianNoise(std::uint64_t seed) : random_(seed) {}
  /// One number of standard deviation 1.
  double operator()();

 private:
  Random random_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace saltus
