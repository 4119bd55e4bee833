// A quadratic program in stages, packed for the interior-point method: models KktSystem with a
// Riccati recursion. Derivation: framework/design/riccati.md.
#pragma once

#include <span>
#include <vector>

#include "saltus/qp/lanes.hpp"
#include "saltus/qp/riccati_kernels.hpp"
#include "saltus/qp/row_kernels.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::qp {

/// Hands out pieces of an array that was sized once.
template <class T, class Storage>
class Arena {
 public:
  Arena() = default;
  explicit Arena(std::size_t capacity) : storage_(capacity), capacity_(capacity) {}
  void reset() { used_ = 0; }
  T* take(int count) {
    const std::size_t step = (static_cast<std::size_t>(count) + 7) / 8 * 8;
    if (used_ + step > capacity_) return nullptr;
    T* result = storage_.data() + used_;
    used_ += step;
    return result;
  }

 private:
  Storage storage_;
  std::size_t used_ = 0, capacity_ = 0;
};

/// Bounds of a range of the stage's main variables.
struct BoundBlock {
  int first = 0, length = 0;  ///< in whole vectors
  int lower_at = -1, upper_at = -1;
};

struct PackedStage {
  SweepStage sweep;
  const RiccatiKernel* kernel = nullptr;
  int v_at = 0;               ///< main variables (x, u) in v; further parts of the inputs follow
  int costate_at = 0;         ///< multipliers of the dynamics that end this stage, in y
  const double* H = nullptr;  ///< n x n, both triangles
  const double* g = nullptr;
  const double* b = nullptr;
  int constant_states = 0;  ///< of the user's x that are not variables (fixed start)
  int free_states = 0;      ///< of the user's x that count as inputs (free start)
  // Inputs in parts with a common resultant (parts = 1: none).
  int parts = 1;
  const double* T = nullptr;  ///< per further part, B_p = B_1 T_p
  const double* T_inverse = nullptr;
  const double* R = nullptr;  ///< per further part, its Hessian in resultant coordinates
  const double* r = nullptr;
  double* R_work = nullptr;  ///< with the barrier
  Split* splits = nullptr;   ///< per further part
  const SplitKernel* split_kernel = nullptr;
  std::span<RowBlock> rows;
  BoundBlock bounds;
};

class RiccatiSystem {
 public:
  /// Sized for the capacity of the program; `kernels` of fixed sizes are used where they fit.
  RiccatiSystem(const StageQp& capacity, std::span<const RiccatiKernel> kernels);

  /// Copies the data. False if they are not a problem: NaN, crossed bounds, sizes beyond capacity.
  bool pack(const StageQp& qp);
  void pack_point(const StageQp& qp, const StagePoint& point, bool multipliers, double* v,
                  double* y, double* lambda) const;
  void unpack_point(const StageQp& qp, const double* v, const double* y, const double* lambda,
                    StagePoint& point) const;
  /// Replaces the states in v by those that the dynamics give for its inputs.
  void roll_out(double* v);

  int max_variables() const { return max_variables_; }
  int max_equalities() const { return max_equalities_; }
  int max_sides() const { return max_sides_; }

  // KktSystem.
  int variables() const { return variables_; }
  int equalities() const { return equalities_; }
  int sides() const { return sides_; }
  int first_soft() const { return first_soft_; }
  const double* active() const { return active_.data(); }
  const double* beta() const { return beta_.data(); }
  const double* l1() const { return l1_.data(); }
  const double* l2() const { return l2_.data(); }
  void evaluate(const double* v, const double* y, const double* lambda, double* stationarity,
                double* equality, double* side);
  void apply(const double* v, const double* y, const double* lambda, double* stationarity,
             double* equality, double* side);
  double cost(const double* v);
  void expect_convex(bool convex) { expects_convex_ = convex; }
  void set_shift(double shift) { shift_ = shift; }
  bool factor(const double* weights);
  void solve(const double* gradient, const double* equality, double* dv, double* dy);
  void multiply(const double* v, double* side);
  void multiply_transposed(const double* side, double* v);

  /// Whether equality rows of a fixed start alone do not hold.
  bool contradicts_itself() const { return contradiction_; }
  /// Stages whose inputs were reduced to their resultant.
  int reduced_stages() const { return reduced_stages_; }

 private:
  struct Packer;
  const double* with_resultant(const PackedStage& stage, const double* v);
  template <bool affine>
  void products(const double* v, const double* y, double* stationarity, double* equality);
  template <int sign>
  void add_sides(const double* side, double* v);
  void penalise_settled_rows(const StageQp& qp, StagePoint::AtStage& to) const;
  void add_rows(PackedStage& stage, const double* weights);
  void factor_parts(PackedStage& stage);
  void sweep(const double* gradient, const double* equality, double* dv, double* dy);
  void solve_with_rows(const double* gradient, const double* equality, double* dv, double* dy);

  std::vector<RiccatiKernel> kernels_;
  std::vector<PackedStage> stages_;
  std::vector<RowBlock> blocks_;
  std::vector<Split> splits_;
  Arena<double, AlignedArray> numbers_;
  Arena<int, std::vector<int>> integers_;
  AlignedArray active_, beta_, l1_, l2_;  // per side
  AlignedArray wanted_;                   // per entry of y: right-hand sides of equality rows
  AlignedArray weights_, side_work_, work_, row_work_, sum_;
  AlignedArray gradient_, residual_v_, residual_y_, correction_v_, correction_y_;
  int max_variables_ = 0, max_equalities_ = 0, max_sides_ = 0;
  int variables_ = 0, equalities_ = 0, sides_ = 0, first_soft_ = 0;
  double equality_weight_ = 0.0;
  double shift_ = 0.0;
  int reduced_stages_ = 0;
  bool expects_convex_ = true;
  bool has_equality_rows_ = false, contradiction_ = false;
};

}  // namespace saltus::qp
