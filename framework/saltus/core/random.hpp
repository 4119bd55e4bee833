// Random numbers that are the same with every compiler, which the distributions of the standard do
// not promise.
#pragma once

#include <cmath>
#include <cstdint>
#include <random>

#include "saltus/core/types.hpp"

namespace saltus {

/// Random numbers that are the same for the same seed, on every machine.
class Random {
 public:
  /// The same seed gives the same numbers.
  explicit Random(std::uint64_t seed) : engine_(seed) {}
  double uniform(double low, double high) {  ///< 53 bits, `high` excluded
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  /// Between low and high, both > 0, uniform in its logarithm.
  double log_uniform(double low, double high) {
    return std::exp(uniform(std::log(low), std::log(high)));
  }
  int integer(int low, int high) {  ///< both included
    return low + static_cast<int>(engine_() % static_cast<std::uint64_t>(high - low + 1));
  }
  /// True with this probability.
  bool chance(double probability) { return uniform(0.0, 1.0) < probability; }
  /// Entries in [-1, 1), drawn column by column.
  MatrixXd matrix(int rows, int columns) {
    MatrixXd m(rows, columns);
    for (int j = 0; j < columns; ++j)
      for (int i = 0; i < rows; ++i) m(i, j) = uniform(-1.0, 1.0);
    return m;
  }
  /// n numbers as matrix() draws them.
  VectorXd vector(int n) { return matrix(n, 1); }

 private:
  std::mt19937_64 engine_;
};

}  // namespace saltus
