// State that the steps of one PackedQp::pack() call share. Private to packed_qp.cpp and pack_*.cpp.
#pragma once

#include <algorithm>
#include <cmath>

#include "saltus/qp/packed_qp.hpp"

namespace saltus::qp {

struct Packing {
  PackedQp& to;
  const StageQp& qp;
  int v = 0, y = 0, hard = 0, soft = 0, blocks = 0;  ///< number of entries assigned so far
  bool ok = true;         ///< false if a step found an invalid program or exceeded the capacity
  int cost_compared = 0;  ///< stage that cost_repeats refers to
  bool cost_repeats = false;

  /// pack_stage.cpp: packs sizes, dynamics and cost of a stage. Call it for all stages in order,
  /// before any rows.
  bool stage(int k);
  /// Allocates the work space of the factorisation, once the sizes of all stages are known.
  bool allocate_recursion();
  /// pack_rows.cpp: packs the groups and bounds of a stage into blocks of rows.
  bool rows(int k);
  /// Fills the linear cost and the offsets of the dynamics of a stage.
  void vectors(int k);
  /// pack_sides.cpp: fills the values of all sides and equality rows.
  void fill_sides();
  /// Fills all that depends on the values of a fixed start.
  void start();

 private:
  bool starts_fixed(int k) const { return k == 0 && qp.fixed_start; }
  bool starts_free(int k) const { return k == 0 && !qp.fixed_start; }

  // Position of entry j of the user's v = (x, u): the part and the offset in it. Part -1 marks a
  // constant.
  struct Column {
    int part, offset;
  };
  Column column_of(int k, int j) const;

  // Returns a piece of the program's memory. Beyond the capacity, returns null and sets ok = false.
  double* numbers(int count) { return taken(to.storage.numbers.take(count)); }
  int* integers(int count) { return taken(to.storage.integers.take(count)); }
  double* zeros(int count) {
    double* piece = numbers(count);
    if (piece != nullptr) std::fill_n(piece, count, 0.0);
    return piece;
  }
  template <class T>
  T* taken(T* piece) {
    if (piece == nullptr) ok = false;
    return piece;
  }

  bool has_same_cost_as_previous(int k);
  void choose_parts(int k);
  bool find_maps(int k, int parts);
  void dynamics(int k);
  void hessian(int k);
  void make_splits(int k);

  RowBlock& new_block(int k, int group, int rows, int columns, int part);
  void finish_block(int k, RowBlock& block, const RowBlock* twin);
  int* targets(const RowBlock& block, int first, int ld);
  double* products_of_pairs(const RowBlock& block);
  void give_offsets(RowBlock& block, bool equalities, bool has_lower, bool has_upper);

  // Implemented in pack_groups.cpp.
  bool add_group(int k, int g, bool equalities);
  bool repeat_group(int k, int g);
  bool depends_on_start_only(int k, int g, int row);
  const RowBlock* only_block_of(int k, int g) const;
  double* coefficients(int k, const RowBlock& block, const int* user_column, int user_columns);
  void keep_single_entries(RowBlock& block, double* C, int* column);
  void scale_rows(RowBlock& block, double* C);
  const RowBlock* twin_of(int k, const RowBlock& block) const;

  // Implemented in pack_bounds.cpp.
  bool without_bounds(int k) const;
  void bounds(int k);
  void add_bound_rows(int k, int part, bool equalities, int begin, int end);

  void fill_rows(int k, RowBlock& block);
  double constant_part(const RowGroup& group, int row) const;
  void fill_bounds(int k);
  void fill_like_twin(RowBlock& block);
  void set_side(int side, double value, double sign);
};

/// True if the leading rows x columns of both matrices have the same bits.
bool same(const MatrixXd& a, const MatrixXd& b, int rows, int columns);
bool same(const VectorXd& a, const VectorXd& b, int rows);

/// Bounds of entry j of v = (x, u).
inline double lower_bound(const Stage& s, int j) {
  return j < s.nx ? s.x_lower[j] : s.u_lower[j - s.nx];
}
inline double upper_bound(const Stage& s, int j) {
  return j < s.nx ? s.x_upper[j] : s.u_upper[j - s.nx];
}

/// Records which sides exist in a set of rows.
struct Sides {
  bool lower = false, upper = false;
  void see(double l, double u) {
    lower = lower || l != -infinity;
    upper = upper || u != infinity;
  }
};

/// True if no finite value lies between l and u. Also true for NaN.
inline bool crossed(double l, double u) { return !(l <= u && l < infinity && u > -infinity); }
inline bool without_sides(double l, double u) { return l == -infinity && u == infinity; }

/// Returns the kernel for this size, or the last one, which fits every size.
template <class Kernel, std::size_t count>
const Kernel* kernel_for(const Kernel (&kernels)[count], int Kernel::*size, int wanted) {
  for (const Kernel& k : kernels)
    if (k.*size == wanted) return &k;
  return &kernels[count - 1];
}

}  // namespace saltus::qp
