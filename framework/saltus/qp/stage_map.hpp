// From a sparse program whose stages are known to the program in stages, and points of either to
// points of the other.
#pragma once

#include <memory>
#include <span>

#include "saltus/core/entry_target.hpp"
#include "saltus/core/primal_dual_point.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/qp/stage_structure.hpp"

namespace saltus {

/// What became of the numbers of a sparse program.
enum class StageFill {
  filled,
  /// A row of which every variable has equal bounds is violated, or a given start is outside the
  /// bounds of its variable.
  infeasible,
  /// Not expressible with these numbers: a row of the dynamics that is no equality, a slack with an
  /// upper bound or a negative weight, or two variables carried into one stage as one state.
  not_staged
};

/// Rows of a program that are written straight into the stages, without a sparse matrix between.
class DirectRows {
 public:
  virtual ~DirectRows() = default;
  /// Writes every entry of the rows' pattern to its target; of rows without bounds none.
  virtual bool write(std::span<const EntryTarget> targets) noexcept = 0;
  virtual void multiply(const VectorXd& w, VectorXd& rows) const noexcept = 0;  ///< rows = J w
  /// gradient += J' lambda.
  virtual void add_transposed(const VectorXd& lambda, VectorXd& gradient) const noexcept = 0;
};

/// Variables with equal bounds, rows without bounds and slacks vanish; what is left is written into
/// the stages by lists of offsets. The lists of a stage are made anew only where something in it
/// appeared or vanished. After construction nothing allocates.
///
/// Global variables are inputs of the stage before the first that uses them and states from there
/// on. If that is the first one, a stage is put in front in which nothing else happens.
///
/// The cost of a carried variable alone stays in the stage of the variable; where it is carried to,
/// only what it shares with others is left. The Hessian of one stage may thus be indefinite though
/// the program is convex: recursions over stages do not mind, solvers that expect every stage to be
/// convex do.
class StageMap {
 public:
  /// Throws DefinitionError if the structure does not fit the patterns, naming what does not.
  StageMap(const SparseQp& patterns, StageStructure structure);
  StageMap(StageMap&&) noexcept;
  StageMap& operator=(StageMap&&) noexcept;
  ~StageMap();

  /// The program in stages as of the last fill(); its address stays.
  const StageQp& stages() const;
  StageFill fill(const SparseQp& qp) noexcept;

  /// From now on the rows' entries come from `rows`, and `qp`, which is the one that will be
  /// filled, keeps only those that stand in no stage. Both must outlive the map.
  void write_directly(SparseQp& qp, DirectRows& rows);
  /// As fill(qp); unless `rows_changed`, only what moved to another column is written again.
  StageFill fill(const SparseQp& qp, bool rows_changed) noexcept;
  /// Direct rows: since the last fill() nothing but the values of a given start has changed.
  void restart(const VectorXd& row_sides) noexcept;

  // For the program of the last fill(), which must have succeeded.
  /// All variables and multipliers, those of vanished variables included. `to` is resized.
  void convert(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to) noexcept;
  /// `to` was made for stages(). Without multipliers in `from` those of `to` are zero.
  void convert(const SparseQp& qp, const PrimalDualPoint& from, StagePoint& to) noexcept;

 private:
  struct Lists;  // stage_map_lists.hpp
  std::unique_ptr<Lists> lists_;
};

}  // namespace saltus
