// A quadratic program in stages as the Riccati recursion reads it: columns padded to whole vectors,
// rows in blocks, and what repeats from stage to stage stored once. A value without a solver.
//
// The program is  min 1/2 v'Hv + g'v  subject to  E v = e,  G v >= beta  (see kkt_system.hpp). In v
// the stages follow one another, each with its main variables (x, u), then the inputs of further
// parts; in y the dynamics of all stages, then equality rows; sides are first hard, then soft.
// A fixed start is no variable: it goes into b, g and the rows. A free start counts as inputs.
#pragma once

#include <span>
#include <vector>

#include "saltus/qp/arena.hpp"
#include "saltus/qp/lanes.hpp"
#include "saltus/qp/riccati_kernels.hpp"
#include "saltus/qp/row_kernels.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::qp {

/// Most groups of inputs with a common resultant.
inline constexpr int max_parts = 8;

/// Bounds of a range of the stage's main variables.
struct BoundBlock {
  int first = 0, length = 0;         ///< in whole vectors
  int lower_at = -1, upper_at = -1;  ///< first side, -1: no lower (upper) sides
};

/// Groups of inputs that act through a common resultant are the stage's parts: the first one stands
/// among the main variables, a further one as T_p u_p, so that what the dynamics see is their sum.
struct PackedStage {
  SweepStage sweep;  ///< sizes and dynamics; M, L, pivot and p are work of the recursion
  const RiccatiKernel* kernel = nullptr;
  int v_at = 0;                   ///< first of the main variables in v
  int costate_at = 0;             ///< multipliers of the dynamics that end this stage, in y
  const double* H = nullptr;      ///< n x n, both triangles
  const double* outer = nullptr;  ///< H, without the block of the inputs where there are parts
  const double* g = nullptr;
  const double* b = nullptr;
  int constant_states = 0;  ///< of the user's x that are not variables (fixed start)
  int free_states = 0;      ///< of the user's x that count as inputs (free start)

  int parts = 1;              ///< 1: no common resultant
  const double* T = nullptr;  ///< per further part, B_p = B_1 T_p
  const double* T_inverse = nullptr;
  const double* R = nullptr;  ///< per part, its Hessian in resultant coordinates
  const double* r = nullptr;  ///< per further part, its gradient
  double* R_work = nullptr;   ///< with the barrier
  Split* splits = nullptr;    ///< per further part
  const SplitKernel* split_kernel = nullptr;

  std::span<RowBlock> rows;
  BoundBlock bounds;
};

struct PackedQp {
  /// Sized for the capacity of the program; `kernels` of fixed sizes are used where they fit.
  PackedQp(const StageQp& capacity, std::span<const RiccatiKernel> kernels);

  /// Copies the program. False if it is none: NaN, crossed bounds, sizes beyond capacity. Does not
  /// allocate.
  bool pack(const StageQp& qp);

  // Of the program packed last.
  std::vector<PackedStage> stages;
  AlignedArray active, beta, l1, l2;  ///< per side; see KktSystem
  AlignedArray wanted;                ///< per entry of y: e of the equality rows, else 0
  int variables = 0, equalities = 0, sides = 0, first_soft = 0;  ///< sizes, padding included
  bool has_equality_rows = false;                                ///< besides the dynamics
  bool contradiction = false;  ///< a hard row of a fixed start alone, or of nothing, fails
  int reduced_stages = 0;      ///< stages whose inputs were reduced to their resultant

  /// Largest sizes of any program within the capacity; of `work` a stage or block of rows needs.
  struct Capacity {
    int variables = 0, equalities = 0, sides = 0, work = 64;
  };
  Capacity capacity;

  /// What stages and blocks point into. Nobody but pack() looks at it.
  struct Storage {
    std::vector<RiccatiKernel> kernels;
    std::vector<RowBlock> blocks;
    std::vector<Split> splits;
    Arena<double, AlignedArray> numbers;
    Arena<int, std::vector<int>> integers;
  };
  Storage storage;
};

/// A point of the program as entries of v, y and lambda; y and lambda only with `multipliers`.
void pack_point(const StageQp& qp, const StagePoint& point, const PackedQp& packed,
                bool multipliers, double* v, double* y, double* lambda);
void unpack_point(const StageQp& qp, const PackedQp& packed, const double* v, const double* y,
                  const double* lambda, StagePoint& point);

}  // namespace saltus::qp
