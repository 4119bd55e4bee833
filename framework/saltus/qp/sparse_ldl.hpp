// The factor L D L' of a sparse symmetric quasi-definite matrix with a fixed pattern: CHOLMOD's
// simplicial code (LGPL parts only) behind a handle.
#pragma once

#include <memory>
#include <vector>

#include "saltus/core/sparsity.hpp"

namespace saltus::qp {

/// Lower triangle of [H, J'; J, D] with a full diagonal, from that of H and from J.
SparsityPattern quasi_definite_pattern(const SparsityPattern& hessian, const SparsityPattern& rows);
/// Of its pivots, for n variables and m rows.
std::vector<signed char> quasi_definite_signs(int n, int m);

/// Ordering (AMD) and symbolic analysis happen at construction; factor() and solve() do not
/// allocate. A quasi-definite matrix [P, C'; C, -N], P and N positive definite, has such a factor
/// in any order, with as many positive entries of D as P has rows (R. J. Vanderbei, "Symmetric
/// quasidefinite matrices", SIAM J. Optim. 5, 1995).
class SparseLdl {
 public:
  /// Lower triangle. Sign of the expected pivot of each row: +1 or -1.
  SparseLdl(const SparsityPattern& lower, std::vector<signed char> signs);
  ~SparseLdl();
  SparseLdl(const SparseLdl&) = delete;
  SparseLdl& operator=(const SparseLdl&) = delete;

  int rows() const;
  int factor_entries() const;  ///< of L, unit diagonal not counted
  /// Sets the value of an entry of the pattern.
  void set(int entry, double value);
  /// By Sylvester's law the signs of D are the inertia, whatever the order. False if it is not the
  /// expected one, or if a pivot vanished: then there is no factor.
  bool factor();
  /// The same, but the expected inertia may come with other signs elsewhere: that of a matrix
  /// that need not be quasi-definite. Its factor may have lost digits.
  bool factor_with_inertia();
  /// x = inverse of the matrix times x.
  void solve(double* x);

 private:
  struct Handle;
  template <class Visit>
  bool factor_and_visit(Visit visit);
  std::unique_ptr<Handle> handle_;
};

}  // namespace saltus::qp
