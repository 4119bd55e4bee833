// LU factors of a small dense matrix, for equations that are solved inside an evaluation: nothing
// allocates after construction, and a singular matrix says which of its rows depends on the others.
#pragma once

#include <vector>

namespace saltus {

/// P A = L U by elimination with pivots that are largest relative to their row.
class DenseLu {
 public:
  /// For matrices of this size; nothing is allocated afterwards.
  explicit DenseLu(int size);

  /// Rows and columns.
  int size() const { return size_; }
  /// Row of A, to be filled before factor(), which replaces it.
  double* row(int i) { return factors_.data() + i * size_; }
  /// False if a number is not finite, or a row depends on the others to rounding.
  bool factor();
  /// After factor() failed: the row of A that is left without a pivot; -1: a number is not finite.
  int singular_row() const { return singular_row_; }

  /// b <- A^-1 b
  void solve(double* b) const;
  /// The same for a matrix of size() rows, contiguous, with this many columns.
  void solve(double* B, int columns) const;
  /// b <- A^-T b
  void solve_transposed(double* b) const;

 private:
  int size_;
  std::vector<double> factors_;     // L below the diagonal, U on and above it, by rows
  std::vector<double> row_scale_;   // 1 / largest entry of the rows of A, where they stand now
  std::vector<double> inverse_;     // of the diagonal of U
  std::vector<int> pivots_, rows_;  // row swapped with row k; row of A that stands in row k
  int singular_row_ = -1;
};

}  // namespace saltus
