// A small dense solver of convex quadratic programs, for answers independent of the framework.
#pragma once

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"

namespace saltus::testing {

/// minimise 1/2 z'P z + q'z + constant subject to A z = b and G z <= h.
struct DenseQp {
  MatrixXd P, A, G;
  VectorXd q, b, h;
  double constant = 0.0;
  VectorXd scale;  ///< magnitudes of z, positive
};

struct DenseQpResult {
  bool optimal = false;
  double cost = 0.0;
  VectorXd z;
  VectorXd y;  ///< multipliers of A z = b: P z + q + A'y + G'w = 0
  VectorXd w;  ///< multipliers of G z <= h, nonnegative; zero on inactive rows
  /// Largest entry of gradient of the Lagrangian, violation and negative multiplier, in z / scale.
  double residual = infinity;
  int iterations = 0;
};

/// Mehrotra's predictor-corrector method on dense matrices, then the active rows as equations.
/// Does not throw; `optimal` if the residual is at most `tolerance`.
DenseQpResult solve(const DenseQp& qp, double tolerance = 1e-10);

}  // namespace saltus::testing
