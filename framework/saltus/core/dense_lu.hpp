// LU factorisation of a small dense matrix, for equations solved during an evaluation. Nothing
// allocates after construction. If the matrix is singular, the class reports a linearly dependent
// row.
#pragma once

#include <vector>

namespace saltus {

namespace detail {

/// Factors P A = L U with scaled partial pivoting.
class DenseLu {
 public:
  /// Allocates for matrices of this size.
  explicit DenseLu(int size);

  /// Number of rows and columns.
  int size() const { return size_; }
  /// Row i of A. Fill all rows before factor(), which overwrites them with the factors.
  double* row(int i) { return factors_.data() + i * size_; }
  /// Returns false if an entry is not finite or the matrix is singular to rounding error.
  bool factor();
  /// Valid after factor() returned false: the row of A without a pivot, or -1 if an entry is not
  /// finite.
  int singular_row() const { return singular_row_; }

  /// b <- A^-1 b
  void solve(double* b) const;
  /// B <- A^-1 B for a row-major matrix of size() rows and the given number of columns.
  void solve(double* B, int columns) const;
  /// b <- A^-T b
  void solve_transposed(double* b) const;

 private:
  int size_;
  std::vector<double> factors_;     // L below the diagonal, U on and above it, row-major
  std::vector<double> row_scale_;   // 1 / largest entry of each row of A, permuted like the rows
  std::vector<double> inverse_;     // 1 / diagonal entries of U
  std::vector<int> pivots_, rows_;  // row swapped with row k; row of A at position k
  int singular_row_ = -1;
};

}  // namespace detail

}  // namespace saltus
