// Random numbers from a seed, identical on every machine. The standard library's distributions are
// not.
#pragma once

#include <cstdint>
#include <random>

#include "saltus/core/types.hpp"

namespace saltus::test {

class Draw {
 public:
  explicit Draw(std::uint32_t seed) : engine_(seed) {}

  double real(double lower, double upper) {
    return lower + (upper - lower) * static_cast<double>(engine_()) / 4294967296.0;
  }
  bool chance(double share) { return real(0.0, 1.0) < share; }
  int whole(int first, int last) { return first + static_cast<int>(real(0.0, last - first + 1.0)); }
  MatrixXd matrix(int rows, int columns, double size) {
    MatrixXd m(rows, columns);
    for (int j = 0; j < columns; ++j)
      for (int i = 0; i < rows; ++i) m(i, j) = real(-size, size);
    return m;
  }
  VectorXd vector(int rows, double size) { return matrix(rows, 1, size); }

 private:
  std::mt19937 engine_;
};

}  // namespace saltus::test
