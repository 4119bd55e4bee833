// Ipopt behind the Solver interface.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "saltus/solver/solver.hpp"

namespace saltus {

/// How Ipopt solves.
struct IpoptOptions {
  /// Scaled KKT error. A result whose reported residual, NlpResult::kkt, is larger than the
  /// tolerance is `acceptable` up to 100 times the tolerance, and no success beyond.
  double tolerance = 1e-8;
  int max_iterations = 500;  ///< after which it gives up
  double time_limit = 0.0;   ///< s of wall clock, 0: none; works with Ipopt 3.11 too
  /// Hessian of the Lagrangian; exact where the problem offers it.
  Curvature curvature = Curvature::exact;
  /// Relaxation of bounds before the solve; 0 solves the problem as stated.
  double bound_relaxation = 0.0;
  /// Mehrotra's predictor-corrector: fewer iterations, for convex quadratic programs only.
  bool mehrotra = false;
  bool adaptive_barrier = false;     ///< "adaptive" in place of "monotone" barrier updates
  double warm_start_barrier = 1e-6;  ///< initial barrier parameter of warm starts
  int print_level = 0;               ///< Ipopt's own, 0: silent
  /// Threads of the BLAS under the linear solver, where it can be told (OpenBLAS). The dense blocks
  /// of optimal control problems are small: more threads wait for one another. 0: as it is.
  int blas_threads = 1;
  /// Ipopt's own options by name, after all of the above: {{"mu_init", "1e-2"}}. Numbers are
  /// written as text.
  std::vector<std::pair<std::string, std::string>> named = {};
};

/// Works with Ipopt 3.11 to 3.14. Throws DefinitionError where it does not know a named option, or
/// not that value.
std::unique_ptr<Solver> make_ipopt(const IpoptOptions& options = {});

}  // namespace saltus
