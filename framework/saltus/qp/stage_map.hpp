// Maps a sparse program with known stages to a program in stages, and points in both directions.
#pragma once

#include <memory>
#include <span>

#include "saltus/core/sparsity.hpp"
#include "saltus/core/types.hpp"
#include "saltus/qp/qp_result.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::qp {

/// Result of filling the stages with the values of a sparse program.
enum class StageFill {
  filled,
  /// A row whose variables all have equal bounds is violated, or a given start is outside the
  /// bounds of its variable.
  infeasible,
  /// These values cannot be staged: a row of the dynamics is not an equality, a slack has an upper
  /// bound or a negative weight, or two variables are carried into one stage as one state.
  not_staged
};

/// Rows of a program that are written directly into the stages, without a sparse matrix.
class DirectRows {
 public:
  virtual ~DirectRows() = default;
  /// Writes every entry of the row pattern to its target, except entries of rows without bounds.
  virtual bool write(std::span<const detail::EntryTarget> targets) noexcept = 0;
  virtual void multiply(const VectorXd& w, VectorXd& rows) const noexcept = 0;  ///< rows = J w
  /// gradient += J' lambda.
  virtual void add_transposed(const VectorXd& lambda, VectorXd& gradient) const noexcept = 0;
};

/// Variables with equal bounds, rows without bounds and slacks are eliminated. The remaining values
/// are written into the stages by lists of offsets. The lists of a stage are rebuilt only if an
/// entry of it appeared or vanished. After construction nothing allocates.
///
/// Global variables are inputs of the stage before the first stage that uses them, and states from
/// there on. If the first stage uses them, an additional empty stage is inserted before it.
///
/// The cost of a carried variable alone stays in the stage of the variable. The stages that it is
/// carried to hold only the terms shared with other variables. The Hessian of one stage may thus be
/// indefinite although the program is convex. Recursions over stages allow this; solvers that
/// expect every stage to be convex do not.
class StageMap {
 public:
  /// Throws DefinitionError if the structure does not fit the patterns and names the mismatch.
  StageMap(const SparseQp& patterns, StageStructure structure);
  StageMap(StageMap&&) noexcept;
  StageMap& operator=(StageMap&&) noexcept;
  ~StageMap();

  /// The program in stages of the last fill(). The reference stays valid.
  const StageQp& stages() const;
  /// Without `matrices_changed`, H and J are those of the last fill(), which must have staged them.
  /// Their entries are written again only if one of them moved to another column.
  StageFill fill(const SparseQp& qp, bool matrices_changed = true) noexcept;

  /// From now on the row entries come from `rows`. `qp` must be the program that is filled later;
  /// it keeps only the entries that belong to no stage. Both must outlive the map.
  void write_directly(SparseQp& qp, DirectRows& rows);
  /// Updates a given start, with direct rows. Nothing else may have changed since the last fill().
  void restart(const VectorXd& row_sides) noexcept;

  // For the program of the last fill(), which must have succeeded.
  /// Converts all variables and multipliers, including those of eliminated variables. Resizes `to`.
  void convert(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to) noexcept;
  /// Converts only the variables and multipliers that are part of the stages, without slacks.
  void convert_part(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to) noexcept;
  /// `to` must be made for stages(). If `from` has no multipliers, those of `to` are set to zero.
  void convert(const SparseQp& qp, const PrimalDualPoint& from, StagePoint& to) noexcept;

 private:
  struct Lists;  // stage_map_lists.hpp
  std::unique_ptr<Lists> lists_;
};

}  // namespace saltus::qp
