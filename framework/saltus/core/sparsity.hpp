// The structure of a sparse matrix: which entries may be non-zero, stored by compressed rows.
#pragma once

#include <utility>
#include <vector>

namespace saltus {

/// Rows in order, columns ascending within a row. Values of a matrix with this pattern are stored
/// in the same order in a plain array of `entries()` doubles.
class SparsityPattern {
 public:
  SparsityPattern() = default;
  /// No entries yet.
  SparsityPattern(int rows, int cols) : cols_(cols), row_start_(rows + 1, 0) {}

  /// From (row, column) pairs in any order; duplicates are merged.
  static SparsityPattern from_pairs(int rows, int cols, std::vector<std::pair<int, int>> pairs);
  /// All entries, row by row.
  static SparsityPattern dense(int rows, int cols);

  /// How many rows.
  int rows() const { return static_cast<int>(row_start_.size()) - 1; }
  /// How many columns.
  int cols() const { return cols_; }
  /// How many entries.
  int entries() const { return static_cast<int>(col_.size()); }

  /// Number of the first entry of a row.
  int row_begin(int row) const { return row_start_[row]; }
  /// One behind the last entry of a row.
  int row_end(int row) const { return row_start_[row + 1]; }
  /// Column of an entry.
  int col(int entry) const { return col_[entry]; }

  /// Position of (row, col) in the value array, or -1.
  int find(int row, int col) const;
  /// Whether there is an entry.
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
