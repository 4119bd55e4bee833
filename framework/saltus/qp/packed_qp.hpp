// A quadratic program in stages in the layout of the Riccati recursion: columns are padded to whole
// vectors, rows are grouped in blocks, and data that repeat from stage to stage are stored once.
//
// The program is  min 1/2 v'Hv + g'v  subject to  E v = e,  G v >= beta  (see kkt_system.hpp). v
// holds the stages in order, each with its main variables (x, u) and then the inputs of further
// parts. y holds the dynamics of all stages, then the equality rows. Hard sides come first, then
// soft ones. A fixed start is not a variable: it enters b, g and the rows. A free start counts as
// inputs.
#pragma once

#include <span>
#include <vector>

#include "saltus/qp/arena.hpp"
#include "saltus/qp/lanes.hpp"
#include "saltus/qp/riccati_kernels.hpp"
#include "saltus/qp/row_kernels.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::qp {

/// Maximum number of input groups with a common resultant.
inline constexpr int max_parts = 8;

/// Bounds of a range of the main variables of a stage.
struct BoundBlock {
  int first = 0, length = 0;         ///< offset and length in whole vectors
  int lower_at = -1, upper_at = -1;  ///< first side; -1: no lower (upper) sides
};

/// Groups of inputs that act through a common resultant are the parts of a stage. The first part
/// belongs to the main variables. A further part p enters as T_p u_p, so that the dynamics see the
/// sum of all parts.
struct PackedStage {
  SweepStage sweep;  ///< sizes and dynamics; M, L, pivot and p are work space of the recursion
  const RiccatiKernel* kernel = nullptr;
  int v_at = 0;        ///< index in v of the first main variable
  int costate_at = 0;  ///< index in y of the multipliers of the dynamics that leave this stage
  const double* H = nullptr;      ///< n x n, both triangles
  const double* outer = nullptr;  ///< H; with several parts, H without the block of the inputs
  double* g = nullptr;
  double* b = nullptr;
  int constant_states = 0;  ///< number of states in the user's x that are not variables (fixed
                            ///< start)
  int free_states = 0;      ///< number of states in the user's x that count as inputs (free start)

  int parts = 1;              ///< 1: no common resultant
  const double* T = nullptr;  ///< per part after the first: B_p = B_1 T_p
  const double* T_inverse = nullptr;
  const double* R = nullptr;  ///< per part: Hessian in resultant coordinates
  double* r = nullptr;        ///< per part after the first: gradient
  double* R_work = nullptr;   ///< R plus the barrier terms
  Split* splits = nullptr;    ///< per part after the first
  const SplitKernel* split_kernel = nullptr;

  std::span<RowBlock> rows;
  BoundBlock bounds;
};

struct PackedQp {
  /// Allocates for the capacity of the program. `kernels` of fixed sizes are used where they fit.
  PackedQp(const StageQp& capacity, std::span<const RiccatiKernel> kernels);

  /// Copies the program. Returns false if the program is invalid: NaN, crossed bounds, or sizes
  /// beyond the capacity. Does not allocate.
  bool pack(const StageQp& qp);
  /// Copies only the start, the linear cost, the offsets of the dynamics and the values of bounds
  /// and penalties. The other data, and which bounds are finite or equal, are those of the last
  /// pack().
  void pack_vectors(const StageQp& qp);
  /// Copies only the values of a fixed start. The last pack() must have found no contradiction.
  void pack_start(const StageQp& qp);

  // Data of the last packed program.
  std::vector<PackedStage> stages;
  AlignedArray active, beta, l1, l2;  ///< per side, see KktSystem
  AlignedArray wanted;                ///< per entry of y: e for equality rows, else 0
  int variables = 0, equalities = 0, sides = 0, first_soft = 0;  ///< sizes, padding included
  bool has_equality_rows = false;  ///< true if there are equality rows other than the dynamics
  bool contradiction = false;      ///< true if a hard row that depends on no variable is violated
  int reduced_stages = 0;  ///< number of stages whose inputs were reduced to their resultant

  /// Largest sizes of any program within the capacity. `work` is the work space of a stage or
  /// block.
  struct Capacity {
    int variables = 0, equalities = 0, sides = 0, work = 64;
  };
  Capacity capacity;

  /// Memory that stages and blocks point into. Only pack() accesses it.
  struct Storage {
    std::vector<RiccatiKernel> kernels;
    std::vector<RowBlock> blocks;
    std::vector<Split> splits;
    Arena<double, AlignedArray> numbers;
    Arena<int, std::vector<int>> integers;
  };
  Storage storage;
};

/// Writes a point of the program to v, and with `multipliers` also to y and lambda.
void pack_point(const StageQp& qp, const StagePoint& point, const PackedQp& packed,
                bool multipliers, double* v, double* y, double* lambda);
void unpack_point(const StageQp& qp, const PackedQp& packed, const double* v, const double* y,
                  const double* lambda, StagePoint& point);

}  // namespace saltus::qp
