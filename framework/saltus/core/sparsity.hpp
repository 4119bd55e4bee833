// The sparsity pattern of a matrix: positions of structural non-zeros in compressed row storage.
#pragma once

#include <utility>
#include <vector>

namespace saltus {

namespace detail {

// Destination of an entry of a sparse matrix if the matrix itself is not stored.

/// Writes *to = scale * entry.
struct EntryTarget {
  double* to = nullptr;  ///< destination
  double scale = 1.0;    ///< factor applied to the entry
};

}  // namespace detail

/// Positions of the entries of a sparse matrix that may be nonzero. Rows are stored in order, with
/// ascending columns within a row. The values of a matrix with this pattern are an array of
/// `entries()` doubles in the same order.
class SparsityPattern {
 public:
  SparsityPattern() = default;
  /// An empty pattern of the given size.
  SparsityPattern(int rows, int cols) : cols_(cols), row_start_(rows + 1, 0) {}

  /// Builds a pattern from (row, column) pairs in any order. Duplicates are merged.
  static SparsityPattern from_pairs(int rows, int cols, std::vector<std::pair<int, int>> pairs);
  /// A full pattern, row by row.
  static SparsityPattern dense(int rows, int cols);

  /// Number of rows.
  int rows() const { return static_cast<int>(row_start_.size()) - 1; }
  /// Number of columns.
  int cols() const { return cols_; }
  /// Number of stored entries.
  int entries() const { return static_cast<int>(col_.size()); }

  /// Index of the first entry of a row.
  int row_begin(int row) const { return row_start_[row]; }
  /// Index after the last entry of a row.
  int row_end(int row) const { return row_start_[row + 1]; }
  /// Column of an entry.
  int col(int entry) const { return col_[entry]; }

  /// Index of (row, col) in the value array, or -1 if it is not stored.
  int find(int row, int col) const;
  /// True if (row, col) is stored.
  bool contains(int row, int col) const { return find(row, col) >= 0; }

  /// Calls visit(row, col, entry) for every stored entry.
  template <class Visit>
  void for_each(Visit&& visit) const {
    for (int r = 0; r < rows(); ++r)
      for (int e = row_start_[r]; e < row_start_[r + 1]; ++e) visit(r, col_[e], e);
  }

  friend bool operator==(const SparsityPattern&, const SparsityPattern&) = default;

 private:
  int cols_ = 0;
  std::vector<int> row_start_{0};
  std::vector<int> col_;
};

}  // namespace saltus
