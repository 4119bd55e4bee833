// Flow of a linear differential equation over unit time and integrals of quadratic forms along it,
// with derivatives in one direction. This is the matrix exponential of the zero-order hold.
//
//   xi' = M xi  ->  xi(1) = F xi(0),  F = exp(M)
//   int_0^1 xi' Q xi ds = xi(0)' G xi(0),  G = int_0^1 exp(M s)' Q exp(M s) ds
//
// Both are Taylor series over tau = 2^-k with |tau M| <= 1/2, doubled k times: F(2 tau) = F(tau)^2,
// G(2 tau) = G(tau) + F(tau)' G(tau) F(tau). This is the Gram matrix of C. Van Loan, Computing
// integrals involving the matrix exponential, IEEE TAC 23 (1978) 395-404, without the growing block
// exp(-M'). If M is a chain of integrators (its graph has no cycle), the series is finite and is
// summed with tau = 1. It is then exact up to the rounding of a few products.
//
// xi = (x | c): the rates of the constants and ramps c do not depend on x. The columns of c may be
// large if c has small units. To make tau depend on x only, c is scaled by a power of two, so that
// its columns do not exceed |M_xx| (or 1/2 if tau = 1 suffices).
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

/// Computes flow and integrals. compute() does not allocate.
class AffineFlow {
 public:
  /// xi has `size` entries, of which the first `states` are states.
  AffineFlow(int states, int size, int forms);

  /// Inputs: M and the symmetric Q_i, with derivatives up to the requested order. compute()
  /// rescales them in place.
  MatrixJet generator;
  std::vector<MatrixJet> forms;

  /// Computes the results with derivatives up to `order` (0, 1 or 2). Returns false if an input is
  /// not finite or too large for any correct digit. The caller must check the results for overflow.
  bool compute(int order);
  MatrixJet flow;
  std::vector<MatrixJet> integrals;

 private:
  bool is_chain(int order);
  double unit_of_columns() const;

  int states_;
  MatrixJet term_, next_;
  std::vector<char> settled_;
  std::vector<MatrixJet> form_terms_;
};

}  // namespace saltus
