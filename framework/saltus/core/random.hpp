// Reproducible random numbers. The distributions of the C++ standard library may differ between
// compilers; these do not.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "saltus/core/types.hpp"

namespace saltus {

/// Pseudo-random generator. The same seed gives the same numbers on every machine.
class Random {
 public:
  /// Seeds the generator.
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {  ///< number in [low, high), 53 random bits
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  /// Log-uniform number between low and high, both > 0.
  double log_uniform(double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  }
  int integer(int low, int high) {  ///< in [low, high], both included
    return low + static_cast<int>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }
  /// True with this probability.
  bool chance(double probability) { return uniform(0.0, 1.0) < probability; }
  /// Matrix with uniform entries in [-1, 1), drawn column by column.
  MatrixXd matrix(int rows, int columns) {
    MatrixXd m(rows, columns);
    for (int j = 0; j < columns; ++j)
      for (int i = 0; i < rows; ++i) m(i, j) = uniform(-1.0, 1.0);
    return m;
  }
  /// Vector of n uniform entries in [-1, 1).
  VectorXd vector(int n) { return matrix(n, 1); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace saltus
