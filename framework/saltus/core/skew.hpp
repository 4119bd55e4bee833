// The matrix of a cross product. Cross products of two vectors, of any scalar, are Eigen's
// a.cross(b).
#pragma once

#include "saltus/core/types.hpp"

namespace saltus {

/// skew(a) b = a x b.
template <class S>
Mat<S, 3, 3> skew(const Vec<S, 3>& a) {
  Mat<S, 3, 3> matrix;
  matrix << S(0.0), -a[2], a[1], a[2], S(0.0), -a[0], -a[1], a[0], S(0.0);
  return matrix;
}

}  // namespace saltus
