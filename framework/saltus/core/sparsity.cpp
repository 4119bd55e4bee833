#include "saltus/core/sparsity.hpp"

#include <algorithm>

namespace saltus {

SparsityPattern SparsityPattern::from_pairs(int rows, int cols,
                                            std::vector<std::pair<int, int>> pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
  SparsityPattern pattern(rows, cols);
  pattern.col_.reserve(pairs.size());
  for (const auto& [row, col] : pairs) {
    pattern.col_.push_back(col);
    ++pattern.row_start_[row + 1];
  }
  for (int r = 0; r < rows; ++r) pattern.row_start_[r + 1] += pattern.row_start_[r];
  return pattern;
}

SparsityPattern SparsityPattern::dense(int rows, int cols) {
  SparsityPattern pattern(rows, cols);
  for (int r = 0; r < rows; ++r) {
    for (int c = 0; c < cols; ++c) pattern.col_.push_back(c);
    pattern.row_start_[r + 1] = static_cast<int>(pattern.col_.size());
  }
  return pattern;
}

int SparsityPattern::find(int row, int col) const {
  const auto begin = col_.begin() + row_start_[row];
  const auto end = col_.begin() + row_start_[row + 1];
  const auto it = std::lower_bound(begin, end, col);
  return it != end && *it == col ? static_cast<int>(it - col_.begin()) : -1;
}

}  // namespace saltus
