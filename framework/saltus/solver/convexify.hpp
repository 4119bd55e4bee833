// Makes a Hessian positive definite, block by block, without new entries.
//
// The Hessian of an optimal control problem has blocks that share no entry, such as a stage, or a
// phase with its free duration. A block V diag(d) V' that is not positive semidefinite is replaced
// by P = V diag(max(|d|, floor)) V', which reverses negative curvature. Let E be the entries of P
// outside the pattern. They are moved to the diagonal: P - E + diag(sum_j |E_ij|) is P plus a
// diagonally dominant matrix, hence positive definite.
//
// In a large block a few variables, such as the duration, couple parts that otherwise share no
// entry. Each part is changed together with an equal share of the rows and columns of the coupling
// variables. The result is positive definite, as a sum of positive definite matrices.
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
  /// Parts with more variables than `largest_part` are shifted by their Gershgorin bound instead.
  explicit Convexification(const SparsityPattern& with_whole_diagonal, int largest_part = 64);

  /// Changes the entries in place. `floor` is relative to the largest eigenvalue of a part.
  void apply(VectorXd& entries, double floor);
  void add_to_diagonal(VectorXd& entries, double shift) const;

 private:
  struct Entry {
    int row, col, position;  // row and col within the part
  };
  // Variables of a part, then the coupling variables of its block.
  struct Part {
    std::vector<int> diagonal;  // positions
    std::vector<Entry> below;
    int own = 0;  // number of variables of the part itself
    int size() const { return static_cast<int>(diagonal.size()); }
  };
  struct Block {
    std::vector<Part> parts;
    int coupling() const { return parts.front().size() - parts.front().own; }
  };
  struct Workspace {
    explicit Workspace(int n) : dense(n, n), rest(n, n), vectors(n, n) {}
    MatrixXd dense, rest, vectors;
  };
  void add_block(const SparsityPattern& pattern, const std::vector<int>& variables,
                 const std::vector<std::vector<int>>& neighbours);
  Workspace* workspace_of(const Part& part);
  void load(const Part& part, double share, MatrixXd& dense) const;
  bool is_convex(const Block& block);
  void project(const Part& part, double share, double floor, VectorXd& entries);
  void shift(const Part& part, double share, double floor, VectorXd& entries);

  int largest_part_;
  std::vector<Block> blocks_;
  std::vector<Workspace> workspaces_;  // one per size
  std::vector<int> diagonal_;
  VectorXd before_;    // entries before the change
  MatrixXd coupling_;  // Schur complement of the coupling variables
  VectorXd radius_;
};

}  // namespace saltus
