// Random numbers that are the same with every compiler: the distributions of the standard are not.
#pragma once

#include <cstdint>
#include <random>

#include "saltus/core/types.hpp"

namespace saltus::bench {

class Uniform {
 public:
  explicit Uniform(std::uint64_t seed) : engine_(seed) {}
  double operator()(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11) * 0x1.0p-53;
  }
  /// Entries in [-1, 1], drawn column by column.
  MatrixXd matrix(int rows, int columns) {
    MatrixXd m(rows, columns);
    for (int j = 0; j < columns; ++j)
      for (int i = 0; i < rows; ++i) m(i, j) = (*this)(-1.0, 1.0);
    return m;
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace saltus::bench
