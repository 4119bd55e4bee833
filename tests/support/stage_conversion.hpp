// Converts a program in stages to a sparse program, and points in both directions.
#pragma once

#include <vector>

#include "saltus/core/types.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus {

/// The sparse form for the sizes at construction. Variables stage by stage: x, u, and for each soft
/// row the violations t >= 0 of its lower and of its upper side. Rows stage by stage:
///
///     lower <= M v [+ t_lower - t_upper] <= upper  for each group,   A x + B u - x_next = -b.
///
/// Blocks are stored in full, zeros included, so that the pattern holds for any numbers. A fixed
/// start is a variable with equal bounds; the t of an infinite side is held at zero.
class StageConversion {
 public:
  explicit StageConversion(const qp::StageQp& qp);

  const qp::SparseQp& sparse() const { return sparse_; }
  /// Takes new numbers for the same sizes. Throws a DefinitionError if the sizes differ. Does not
  /// allocate.
  void update(const qp::StageQp& qp);

  /// Computes slacks and their multipliers from the values of the rows. Does not allocate if `to`
  /// already has the right sizes.
  void convert(const qp::StageQp& qp, const qp::StagePoint& from, PrimalDualPoint& to) const;
  /// `to` must have the sizes of the program or larger ones. The multiplier of a fixed start goes
  /// to its x_bound.
  void convert(const PrimalDualPoint& from, qp::StagePoint& to) const;

 private:
  struct Group {
    int rows, first_row;
    int first_slack;  // two per row; -1: hard
    std::vector<int> columns;
  };
  struct StageOffset {
    int nx, nu, x, u;    // sizes, first variables
    int next, dynamics;  // successor's nx, first row of the dynamics
    std::vector<Group> groups;
  };
  bool fits(const qp::StageQp& qp) const;
  template <class Emit>
  void for_each_hessian(const qp::StageQp& qp, Emit&& emit) const;
  template <class Emit>
  void for_each_row_entry(const qp::StageQp& qp, Emit&& emit) const;

  std::vector<StageOffset> offsets_;
  int variables_ = 0, rows_ = 0;
  qp::SparseQp sparse_;
};

inline qp::SparseQp to_sparse(const qp::StageQp& qp) { return StageConversion(qp).sparse(); }

}  // namespace saltus
