// Compares scalars with all their derivatives. Makes scalars with distinct derivatives.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "saltus/autodiff/dual.hpp"

namespace saltus {

// Rounding error of a few operations on numbers of order one.
inline constexpr double rounding = 1e-14;

// All components of a scalar, so that laws compare derivatives too.
inline void flatten(double x, std::vector<double>& numbers) { numbers.push_back(x); }
template <class T, int N>
void flatten(const Dual<T, N>& x, std::vector<double>& numbers) {
  flatten(x.value, numbers);
  if constexpr (N > 0)
    for (int i = 0; i < N; ++i) flatten(x.tangent[i], numbers);
}
template <class S>
void expect_same(const S& a, const S& b, double tolerance = rounding) {
  std::vector<double> left, right;
  flatten(a, left);
  flatten(b, right);
  for (std::size_t i = 0; i < left.size(); ++i)
    EXPECT_NEAR(left[i], right[i], tolerance * (1.0 + std::abs(right[i]))) << "component " << i;
}

// A scalar whose components all differ.
inline void fill(double& x, double start) { x = start; }
template <class T, int N>
void fill(Dual<T, N>& x, double start) {
  x = 0.0;
  fill(x.value, start);
  if constexpr (N > 0)
    for (int i = 0; i < N; ++i) {
      T factor;
      fill(factor, 0.3 + 0.7 * start - 0.11 * i);
      x.tangent.set(i, factor);
    }
}
template <class S>
S number(double start) {
  S x;
  fill(x, start);
  return x;
}

}  // namespace saltus
