// A = L L' of a symmetric positive definite matrix, and solves with it. Compiled once for the sizes
// in use: a factorisation of Eigen costs each file that has one seconds.
#pragma once

#include <Eigen/Cholesky>

#include "saltus/core/types.hpp"

namespace saltus {

/// Of n rows, 6 or Eigen::Dynamic. Nothing allocates while the size stays.
template <int n>
class Cholesky {
 public:
  Cholesky() = default;
  /// For matrices of up to so many rows.
  explicit Cholesky(int rows) : factor_(rows) {}
  /// Reads the lower triangle.
  void compute(const Mat<double, n, n>& A);
  /// B becomes A^-1 B.
  void solve_in_place(Eigen::Ref<MatrixXd> B) const;
  /// b becomes the solution.
  void solve_in_place(Vec<double, n>& b) const;

 private:
  Eigen::LLT<Mat<double, n, n>> factor_;
};

}  // namespace saltus
