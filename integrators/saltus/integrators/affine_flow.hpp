// The flow of a linear differential equation over unit time and the integrals of quadratic forms
// along it, with derivatives in one direction: the matrix exponential behind the zero-order hold.
//
//   xi' = M xi  ->  xi(1) = F xi(0),  F = exp(M)
//   int_0^1 xi' Q xi ds = xi(0)' G xi(0),  G = int_0^1 exp(M s)' Q exp(M s) ds
//
// Both are summed as Taylor series over tau = 2^-k, chosen so that |tau M| <= 1/2, and doubled k
// times: F(2 tau) = F(tau)^2, G(2 tau) = G(tau) + F(tau)' G(tau) F(tau). This is the Gram matrix of
// C. Van Loan, Computing integrals involving the matrix exponential, IEEE TAC 23 (1978) 395-404,
// without the growing block exp(-M'). When M is a chain of integrators (its graph has no cycle) the
// series ends by itself and is summed with tau = 1: exact up to the rounding of a few products.
//
// xi = (x | c): the rates of the constants and ramps c behind the states do not read x. Their
// columns may be as large as the unit of c is small; so that tau follows from x alone, c is
// measured in a power of two in which they are not above |M_xx| (nor, as long as tau = 1 will do,
// 1/2).
#pragma once

#include <array>
#include <vector>

#include "saltus/integrators/interval_field.hpp"

namespace saltus {

/// A square matrix and its first two derivatives along one scalar direction.
struct MatrixJet {
  std::array<RowMajorMatrix, 3> derivative;

  void resize(int size);
  void set_zero(int order);
  RowMajorMatrix& operator[](int k) { return derivative[k]; }
  const RowMajorMatrix& operator[](int k) const { return derivative[k]; }
};

/// Work space for one size; compute() does not allocate.
class AffineFlow {
 public:
  /// xi has `size` entries, the first of which are `states`.
  AffineFlow(int states, int size, int forms);

  /// Inputs: M and the symmetric Q_i, with derivatives up to the order asked for. compute() leaves
  /// them in units of its own.
  MatrixJet generator;
  std::vector<MatrixJet> forms;

  /// Results with derivatives up to `order` (0, 1 or 2). False when an input is not finite or so
  /// large that no digit would be right; a result that overflows is left to the caller to see.
  bool compute(int order);
  MatrixJet flow;
  std::vector<MatrixJet> integrals;

 private:
  bool has_no_cycle(int order);
  double unit_of_columns() const;

  int states_;
  MatrixJet term_, next_;
  std::vector<char> settled_;
  std::vector<MatrixJet> form_terms_;
};

}  // namespace saltus
