#include "benchmarks/calibration.hpp"

#include <array>
#include <cmath>
#include <vector>

#include "benchmarks/statistics.hpp"
#include "saltus/core/clock.hpp"

namespace saltus::bench {
namespace {

constexpr int size = 16, rounds = 16, repetitions = 51;
using Matrix = std::array<double, size * size>;  // by columns

// Plain loops without a library: the kernel must not change with a library or the solver.
void add_product(const Matrix& a, const Matrix& b, Matrix& out) {
  for (int j = 0; j < size; ++j)
    for (int k = 0; k < size; ++k)
      for (int i = 0; i < size; ++i) out[i + size * j] += a[i + size * k] * b[k + size * j];
}

// Lower factor in place; the upper triangle is unchanged.
void factor(Matrix& a) {
  for (int j = 0; j < size; ++j) {
    const double root = std::sqrt(a[j + size * j]);
    for (int i = j; i < size; ++i) a[i + size * j] /= root;
    for (int k = j + 1; k < size; ++k)
      for (int i = k; i < size; ++i) a[i + size * k] -= a[i + size * j] * a[k + size * j];
  }
}

}  // namespace

double calibrate() {
  // a' a + 16 I of entries below one: well conditioned.
  Matrix a{}, transposed{}, start{};
  for (int j = 0; j < size; ++j)
    for (int i = 0; i < size; ++i)
      a[i + size * j] = transposed[j + size * i] = std::cos(1.0 + i + size * j);
  for (int i = 0; i < size; ++i) start[i + size * i] = size;

  volatile double sink = 0.0;  // otherwise the compiler would remove the computation
  std::vector<double> times;
  for (int repetition = 0; repetition < repetitions; ++repetition) {
    const double begin = thread_microseconds();
    for (int round = 0; round < rounds; ++round) {
      Matrix product = start;
      product[0] += round;
      add_product(transposed, a, product);
      factor(product);
      sink = sink + product[size * size - 1];
    }
    times.push_back(thread_microseconds() - begin);
  }
  return spread(std::move(times)).median;
}

}  // namespace saltus::bench
