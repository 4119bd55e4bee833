// The factor L D L' of a sparse symmetric matrix that may be indefinite, with its inertia: a
// multifrontal method with 1 x 1 and 2 x 2 pivots.
//
// Every pivot is at least `threshold` times as large as what it divides; where no such pivot is
// left in a front, its columns are delayed to the parent's. The order is that of minimum degree,
// on a graph in which pairs that are natural 2 x 2 pivots are one node.
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
  /// Lower triangle with the whole diagonal; `pairs` of indices, none of them twice.
  SparseIndefinite(const SparsityPattern& lower, const std::vector<std::pair<int, int>>& pairs);

  int rows() const { return n_; }
  /// Sets the value of an entry of the pattern.
  void set(int entry, double value) { values_[entry] = value; }
  /// False if the matrix is singular to rounding, or not finite.
  bool factor(double threshold);
  /// Why the last factor failed: no pivot above rounding was left.
  bool is_singular() const { return is_singular_; }
  /// Negative pivots of the last factor: as many as the matrix has negative eigenvalues.
  int negative() const { return negative_; }
  /// x = inverse of the matrix times x.
  void solve(double* x);

 private:
  struct Entry {
    int position, i, j;
  };
  struct Front {
    std::vector<int> own;     // eliminated here, unless delayed
    std::vector<int> others;  // rows of the columns, later in the order
    std::vector<int> children;
    std::vector<Entry> entries;  // of the matrix
    bool is_root = false;
  };
  // What a front leaves: pivots in turn, then delayed columns, then the others.
  struct Factor {
    std::vector<int> index;
    int pivots = 0;
    std::vector<double> columns;   // pivots of index.size() rows
    std::vector<double> diagonal;  // of D, and beside it: of the pair that begins there
    std::vector<double> beside;
    std::vector<double> rest;  // square, of what is not eliminated
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
  std::vector<int> where_;  // in the present front
  std::vector<double> work_, largest_;
  int delayed_ = 0;  // into the present front
  int negative_ = 0;
  bool is_singular_ = false;
};

}  // namespace saltus::qp
