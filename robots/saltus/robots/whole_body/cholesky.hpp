// Cholesky factorisation A = L L' of a symmetric positive definite matrix. Compiled once for the
// sizes in use: each file that instantiates a factorisation of Eigen takes seconds longer to
// compile.
#pragma once

#include <Eigen/Cholesky>

#include "saltus/core/types.hpp"

namespace saltus::robots {

/// Factorisation of a matrix with n rows, 6 or Eigen::Dynamic. Does not allocate while the size
/// stays the same.
template <int n>
class Cholesky {
 public:
  Cholesky() = default;
  /// Allocates for matrices of up to `rows` rows.
  explicit Cholesky(int rows) : factor_(rows) {}
  /// Factorises A; reads only the lower triangle.
  void compute(const Mat<double, n, n>& A);
  /// Replaces B by A^-1 B.
  void solve_in_place(Eigen::Ref<MatrixXd> B) const;
  /// Replaces b by A^-1 b.
  void solve_in_place(Vec<double, n>& b) const;

 private:
  Eigen::LLT<Mat<double, n, n>> factor_;
};

}  // namespace saltus::robots
