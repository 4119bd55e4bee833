// Makes a Hessian positive definite, block by block, without new entries.
//
// The Hessian of an optimal control problem has blocks that share no entry, such as a stage, or a
// phase with its free duration. A block V diag(d) V' that is not positive definite is replaced by P
// = V diag(max(|d|, floor)) V', which reverses negative curvature. Let E be the entries of P
// outside the pattern. They are moved to the diagonal: P - E + diag(sum_j |E_ij|) is P plus a
// diagonally dominant matrix, hence positive definite.
#pragma once

#include <vector>

#include "saltus/core/sparsity.hpp"
#include "saltus/core/types.hpp"

namespace saltus {

/// The pattern with the whole diagonal, as apply() and add_to_diagonal() require.
SparsityPattern with_diagonal(const SparsityPattern& lower_triangle);

/// Symbolic data and memory for Hessians of one pattern. It does not allocate after construction.
class Convexification {
 public:
  /// Blocks with more variables than `largest_block` are shifted by their Gershgorin bound instead.
  explicit Convexification(const SparsityPattern& with_whole_diagonal, int largest_block = 64);

  /// Changes the entries in place. `floor` is relative to the largest eigenvalue of a block.
  void apply(VectorXd& entries, double floor);
  void add_to_diagonal(VectorXd& entries, double shift) const;

 private:
  struct Entry {
    int row, col, position;  // row and col within the block
  };
  struct Block {
    std::vector<int> diagonal;  // positions
    std::vector<Entry> below;
    int workspace = -1;  // -1: block too large
    int size() const { return static_cast<int>(diagonal.size()); }
  };
  struct Workspace {
    explicit Workspace(int n) : dense(n, n), rest(n, n), vectors(n, n) {}
    MatrixXd dense, rest, vectors;
  };
  void project(const Block& block, Workspace& work, VectorXd& entries, double floor);
  void shift(const Block& block, VectorXd& entries, double floor);

  std::vector<Block> blocks_;
  std::vector<Workspace> workspaces_;  // one per size
  std::vector<int> diagonal_;
  VectorXd radius_;
};

}  // namespace saltus
