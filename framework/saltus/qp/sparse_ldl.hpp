// The factor L D L' of a sparse symmetric quasi-definite matrix with a fixed pattern: CHOLMOD's
// simplicial code (LGPL parts only) behind a handle.
#pragma once

#include <memory>
#include <vector>

#include "saltus/core/sparsity.hpp"

namespace saltus::qp {

/// Lower triangle of [H, J'; J, D] with a full diagonal, from the lower triangle of H and from J.
SparsityPattern quasi_definite_pattern(const SparsityPattern& hessian, const SparsityPattern& rows);
/// Signs of the pivots of that matrix for n variables and m rows.
std::vector<signed char> quasi_definite_signs(int n, int m);

/// Ordering (AMD) and symbolic analysis happen at construction; factor() and solve() do not
/// allocate. A quasi-definite matrix [P, C'; C, -N], P and N positive definite, has an L D L'
/// factor in any order. D has as many positive entries as P has rows (R. J. Vanderbei, "Symmetric
/// quasidefinite matrices", SIAM J. Optim. 5, 1995).
class SparseLdl {
 public:
  /// `lower` is the lower triangle; `signs` are the expected pivot signs of the rows, +1 or -1.
  SparseLdl(const SparsityPattern& lower, std::vector<signed char> signs);
  ~SparseLdl();
  SparseLdl(const SparseLdl&) = delete;
  SparseLdl& operator=(const SparseLdl&) = delete;

  int rows() const;
  /// Sets the value of an entry of the pattern.
  void set(int entry, double value);
  /// By Sylvester's law the signs of D give the inertia in any order. Returns false if the signs
  /// are not as expected or a pivot vanished; there is no factor then.
  bool factor();
  /// Like factor(), but only the number of negative pivots must match, not their positions. The
  /// matrix need not be quasi-definite. The factor may have lost digits.
  bool factor_with_inertia();
  /// Replaces x by the inverse of the matrix times x.
  void solve(double* x);

 private:
  struct Handle;
  template <class Visit>
  bool factor_and_visit(Visit visit);
  std::unique_ptr<Handle> handle_;
};

}  // namespace saltus::qp
