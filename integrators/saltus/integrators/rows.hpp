// Vectorised sums of rows of doubles, for sensitivities. Rows whose length is a multiple of `lanes`
// have no scalar remainder.
#pragma once

#include <cstddef>
#include <vector>

#include "saltus/autodiff/dual.hpp"

namespace saltus::rows {
inline namespace SALTUS_LANES_ABI {

inline constexpr int lanes = native_lanes;
using Lanes = Pack<lanes>::Lanes;

/// n rounded up to a multiple of `lanes`.
constexpr int padded(int n) { return (n + lanes - 1) / lanes * lanes; }

// Vector types may alias their elements. A memcpy would use smaller pieces than the next read.
inline Lanes load(const double* from) { return *reinterpret_cast<const Lanes*>(from); }
inline void store(const Lanes& value, double* to) { *reinterpret_cast<Lanes*>(to) = value; }

/// y += a x over n entries.
inline void add_multiple(int n, double a, const double* x, double* y) {
  int i = 0;
  for (; i + lanes <= n; i += lanes) store(load(y + i) + a * load(x + i), y + i);
  for (; i < n; ++i) y[i] += a * x[i];
}

/// Index of a table row and its weight in a sum.
struct Weighted {
  int row;
  double weight;
};

/// out = base + weighted sum of rows of a table with `stride` entries per row. Uses n entries of
/// each row, a multiple of `lanes`. The sum stays in registers.
inline void weighted_sum(int n, const double* base, const std::vector<Weighted>& weighted,
                         const double* table, std::ptrdiff_t stride, double* out) {
  constexpr int block = 4;
  int i = 0;
  for (; i + block * lanes <= n; i += block * lanes) {
    Lanes sum[block];
    for (int k = 0; k < block; ++k) sum[k] = load(base + i + k * lanes);
    for (const Weighted& w : weighted) {
      const double* row = table + w.row * stride + i;
      for (int k = 0; k < block; ++k) sum[k] += w.weight * load(row + k * lanes);
    }
    for (int k = 0; k < block; ++k) store(sum[k], out + i + k * lanes);
  }
  for (; i < n; i += lanes) {
    Lanes sum = load(base + i);
    for (const Weighted& w : weighted) sum += w.weight * load(table + w.row * stride + i);
    store(sum, out + i);
  }
}

}  // namespace SALTUS_LANES_ABI
}  // namespace saltus::rows
