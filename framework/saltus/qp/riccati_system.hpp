// A quadratic program in stages that models KktSystem by a Riccati recursion over a packed program.
// Derivation: framework/design/riccati.md.
#pragma once

#include <span>
#include <vector>

#include "saltus/qp/lanes.hpp"
#include "saltus/qp/packed_qp.hpp"
#include "saltus/qp/riccati_kernels.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::qp {

class RiccatiSystem {
 public:
  /// Allocates for the capacity of the program. `kernels` of fixed sizes are used where they fit.
  RiccatiSystem(const StageQp& capacity, std::span<const RiccatiKernel> kernels);

  /// Returns false if the program is invalid; see PackedQp::pack().
  bool pack(const StageQp& qp);
  /// Copies the vectors of a program with the matrices of the last pack(), which keeps the factor:
  /// see PackedQp::pack_vectors().
  void pack_vectors(const StageQp& qp) { packed_.pack_vectors(qp); }
  void pack_start(const StageQp& qp);
  const PackedQp& packed() const { return packed_; }
  /// Replaces the states in v by a roll-out of its inputs.
  void roll_out(double* v);
  /// Computes g and -e: the right-hand sides of solve() for a step from v = y = lambda = 0.
  void constants(double* stationarity, double* equality) const;

  // Implements KktSystem.
  int variables() const { return packed_.variables; }
  int equalities() const { return packed_.equalities; }
  int sides() const { return packed_.sides; }
  int first_soft() const { return packed_.first_soft; }
  const double* active() const { return packed_.active.data(); }
  const double* beta() const { return packed_.beta.data(); }
  const double* l1() const { return packed_.l1.data(); }
  const double* l2() const { return packed_.l2.data(); }
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
  void add_transposed(const double* side, double* v);
  void row_sizes(double* side);

 private:
  const double* with_resultant(const PackedStage& stage, const double* v);
  template <bool affine>
  void products(const double* v, const double* y, double* stationarity, double* equality);
  template <int sign>
  void add_sides(const double* side, double* v);
  void add_rows(PackedStage& stage, const double* weights);
  void join_parts(PackedStage& stage);
  void sweep(const double* gradient, const double* equality, double* dv, double* dy);
  void solve_with_rows(const double* gradient, const double* equality, double* dv, double* dy);
  void refine(const double* gradient, const double* equality, double* dv, double* dy);
  double largest_of_rows(const double* y) const;
  bool raise_equality_weight(double left);

  PackedQp packed_;
  AlignedArray weights_, side_work_, work_, row_work_, sum_;
  AlignedArray gradient_, residual_v_, residual_y_, correction_v_, correction_y_;
  double equality_weight_ = 0.0, least_equality_weight_ = 0.0;
  double shift_ = 0.0;
  bool expects_convex_ = true;
};

}  // namespace saltus::qp
