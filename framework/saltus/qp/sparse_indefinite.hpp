// The factor L D L' of a sparse symmetric matrix that may be indefinite, with its inertia: a
// multifrontal method with 1 x 1 and 2 x 2 pivots.
//
// Every pivot is at least `threshold` times the entries that it divides. If a front has no such
// pivot left, its columns are delayed to the parent front. The ordering is minimum degree on a
// graph in which natural 2 x 2 pivot pairs are one node.
//
// I. S. Duff and J. K. Reid, The multifrontal solution of indefinite sparse symmetric linear
// equations, ACM Trans. Math. Softw. 9, 1983.
#pragma once

#include <utility>
#include <vector>

#include "saltus/core/sparsity.hpp"

namespace saltus::qp {

class SparseIndefinite {
 public:
  /// `lower` is the lower triangle with the whole diagonal. `pairs` are pairs of indices without
  /// repetition.
  SparseIndefinite(const SparsityPattern& lower, const std::vector<std::pair<int, int>>& pairs);

  int rows() const { return n_; }
  /// Sets the value of an entry of the pattern.
  void set(int entry, double value) { values_[entry] = value; }
  /// Returns false if the matrix is singular to rounding or not finite.
  bool factor(double threshold);
  /// True if the last factor() failed because no pivot exceeded rounding.
  bool is_singular() const { return is_singular_; }
  /// Number of negative pivots of the last factor, which equals the number of negative eigenvalues.
  int negative() const { return negative_; }
  /// Replaces x by the inverse of the matrix times x.
  void solve(double* x);

 private:
  struct Entry {
    int position, i, j;
  };
  struct Front {
    std::vector<int> own;     // eliminated here, unless delayed
    std::vector<int> others;  // rows of the columns that are later in the order
    std::vector<int> children;
    std::vector<Entry> entries;  // entries of the matrix
    bool is_root = false;
  };
  // Result of a front. `index` lists the pivots in order, then delayed columns, then the others.
  struct Factor {
    std::vector<int> index;
    int pivots = 0;
    std::vector<double> columns;  // pivot columns, index.size() rows each
    // diagonal of D; `beside` holds the off-diagonal of the 2 x 2 pivot that begins there
    std::vector<double> diagonal;
    std::vector<double> beside;
    std::vector<double> rest;  // square remainder that is not eliminated
  };

  void order(const SparsityPattern& lower, const std::vector<std::pair<int, int>>& pairs);
  void equilibrate();
  void assemble(const Front& front, Factor& factor);
  bool eliminate(Factor& factor, int candidates, double threshold, bool is_root);

  int n_ = 0;
  SparsityPattern pattern_;
  std::vector<double> values_, scale_;
  std::vector<Front> fronts_;  // children before parents
  std::vector<Factor> factors_;
  std::vector<int> where_;  // position in the current front
  std::vector<double> work_, largest_;
  int delayed_ = 0;  // number of columns delayed into the current front
  int negative_ = 0;
  bool is_singular_ = false;
};

}  // namespace saltus::qp
