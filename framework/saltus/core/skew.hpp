// The skew-symmetric matrix of a cross product. For the product of two vectors use Eigen's
// a.cross(b), which works with every scalar type.
#pragma once

#include "saltus/core/types.hpp"

namespace saltus {

/// Skew-symmetric matrix with skew(a) b = a x b.
template <class S>
Mat<S, 3, 3> skew(const Vec<S, 3>& a) {
  Mat<S, 3, 3> matrix;
  matrix << S(0.0), -a[2], a[1], a[2], S(0.0), -a[0], -a[1], a[0], S(0.0);
  return matrix;
}

}  // namespace saltus
