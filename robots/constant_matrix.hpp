// How is a constant matrix multiplied by a vector of any scalar without inventing dependencies?
//
// A cast to the scalar type followed by Eigen's product computes 0 * w as well, and a sparsity
// tracer must then record a dependence on w. Here a stored zero does not touch the vector.
#pragma once

#include <type_traits>

#include "framework/core/types.hpp"

namespace saltus {

/// A v for a constant A; the entries of A that are exactly zero are skipped.
template <class S, int rows, int cols>
Vec<S, rows> multiply(const Mat<double, rows, cols>& a, const Vec<S, cols>& v) {
  Vec<S, rows> product;
  for (int r = 0; r < rows; ++r) {
    S sum(0.0);
    for (int c = 0; c < cols; ++c) {
      if (a(r, c) == 1.0) {
        sum = sum + v[c];
      } else if (a(r, c) != 0.0) {
        sum = sum + a(r, c) * v[c];
      }
    }
    product[r] = sum;
  }
  return product;
}

/// The same for a matrix that is itself an unknown or a parameter.
template <class S, int rows, int cols>
requires(!std::is_same_v<S, double>) Vec<S, rows> multiply(const Mat<S, rows, cols>& a,
                                                           const Vec<S, cols>& v) {
  return a * v;
}

}  // namespace saltus
