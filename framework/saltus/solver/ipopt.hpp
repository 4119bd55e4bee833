// Implements the Solver interface with Ipopt.
#pragma once

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "saltus/solver/native_solver.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

/// Options of Ipopt.
struct IpoptOptions {
  /// Scaled KKT error. If the reported residual NlpResult::kkt exceeds the tolerance, the result is
  /// `acceptable` up to 100 times the tolerance and a failure above that.
  double tolerance = 1e-8;
  int max_iterations = 500;  ///< iteration limit
  double time_limit = 0.0;   ///< wall-clock limit in seconds; 0: none; also works with Ipopt 3.11
  /// Hessian of the Lagrangian. The default is the exact one if the problem supports it.
  Curvature curvature = Curvature::exact;
  /// Relaxation of bounds before the solve; 0 solves the problem as stated.
  double bound_relaxation = 0.0;
  /// Mehrotra's predictor-corrector: fewer iterations, for convex quadratic programs only.
  bool mehrotra = false;
  bool adaptive_barrier = false;     ///< "adaptive" instead of "monotone" barrier updates
  double warm_start_barrier = 1e-6;  ///< initial barrier parameter of warm starts
  int print_level = 0;               ///< Ipopt's print level; 0: silent
  /// Number of threads of the BLAS that the linear solver uses, if it can be set (OpenBLAS). The
  /// dense blocks of optimal control problems are small, so more threads would mostly wait for each
  /// other. 0: unchanged.
  int blas_threads = 1;
  /// Further Ipopt options by name, applied after all of the above: {{"mu_init", "1e-2"}}. Numbers
  /// are written as text.
  std::vector<std::pair<std::string, std::string>> named = {};
};

/// Works with Ipopt 3.11 to 3.14. Throws DefinitionError if Ipopt rejects a named option or its
/// value.
std::unique_ptr<Solver> make_ipopt(const IpoptOptions& options = {});

// Creates any solver of nonlinear programs by name, for applications with a solver option. Needs
// Ipopt.

/// Options that every solver supports.
struct SolverLimits {
  double tolerance = 1e-8;   ///< scaled KKT error
  int max_iterations = 500;  ///< iteration limit
  double time_limit = 0.0;   ///< wall-clock limit in seconds; 0: none
};
/// Creates the chosen solver with these limits.
std::unique_ptr<Solver> make_solver(SolverChoice choice, const SolverLimits& limits = {});

}  // namespace saltus
