// The native solver of nonlinear programs, based on quadratic models of the program.
//
// Cold starts use the barrier method (barrier_run.hpp): one Newton step per model, accepted by a
// filter. Far from the solution models are inaccurate, and a step costs one factorisation.
//
// Warm starts, and methods without Newton systems, use sequential quadratic programming
// (sqp_run.hpp). It solves every model to convergence and so keeps the information in the
// multipliers. If it does not converge, the barrier method starts again.
//
// A linear-quadratic program is one model, solved once. Missing second derivatives are replaced by
// differences of first ones (differenced_program.hpp).
#pragma once

#include <concepts>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/solver/nonlinear_program.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

// Linear algebra of the native solvers: sparse factorisation or stage by stage.

/// Factory of solvers for the quadratic models of `program` and for its Newton systems. The caller
/// supplies tolerance and iteration limit. A function that makes a qp::QpSolver is also a method,
/// but without Newton systems. Nonlinear solvers then solve every model to convergence.
struct QpMethod {
  /// Creates the solver of quadratic models.
  using MakeSolver = std::function<std::unique_ptr<qp::QpSolver>(
      const NonlinearProgram& program, const SparsityPattern& hessian, const SparsityPattern& rows,
      const qp::QpOptions& options)>;
  /// Creates the Newton system of the barrier method.
  using MakeNewton = std::function<std::unique_ptr<qp::NewtonSystem>(
      const NonlinearProgram& program, const SparsityPattern& hessian,
      const SparsityPattern& rows)>;

  QpMethod() = default;
  /// Method with both factories.
  QpMethod(MakeSolver solver, MakeNewton newton)
      : make_solver(std::move(solver)), make_newton(std::move(newton)) {}
  /// Method from a factory of QP solvers alone; Newton systems are sparse.
  template <class Make>
    requires std::constructible_from<MakeSolver, Make> &&
             (!std::same_as<std::remove_cvref_t<Make>, QpMethod>)
  QpMethod(Make&& make) : make_solver(std::forward<Make>(make)) {}  // NOLINT: implicit conversion

  /// True if a factory is set.
  explicit operator bool() const { return static_cast<bool>(make_solver); }
  /// Creates the solver of quadratic models of a program.
  std::unique_ptr<qp::QpSolver> operator()(const NonlinearProgram& program,
                                           const SparsityPattern& hessian,
                                           const SparsityPattern& rows,
                                           const qp::QpOptions& options) const {
    return make_solver(program, hessian, rows, options);
  }

  MakeSolver make_solver;  ///< factory for quadratic models
  MakeNewton make_newton;  ///< factory for Newton systems
  bool by_stages = false;  ///< true if it needs the rows that define the stages of the program
};

/// Sparse linear algebra for any program.
QpMethod sparse_qp();
/// The structured solver on the stages of the program. Throws DefinitionError if the program has
/// none. Roll-out comes from `options`, the fields of qp::QpOptions from the caller. `kernels` must
/// outlive the method.
QpMethod riccati_qp(qp::RiccatiOptions options = {},
                    std::span<const qp::RiccatiKernel> kernels = {});

// Solvers that users can choose by name.

/// Solver of a nonlinear program.
enum class SolverChoice {
  ipopt,
  sparse,   ///< native solver; quadratic programs by sparse linear algebra
  riccati,  ///< native solver; quadratic programs stage by stage
};
/// Names in settings, for Settings::choice().
const std::vector<std::pair<std::string, SolverChoice>>& solver_choices();
/// Name in settings and results.
const char* name_of(SolverChoice choice);
/// Linear algebra of the native solver of that name. Throws DefinitionError for other solvers.
QpMethod qp_method(SolverChoice choice);

/// Options of the native solver.
struct NativeSolverOptions {
  /// Scaled KKT error. If the reported residual NlpResult::kkt exceeds the tolerance, the result is
  /// `acceptable` up to 100 times the tolerance and a failure above that.
  double tolerance = 1e-8;
  int max_iterations = 500;  ///< limit of quadratic models; for a linear-quadratic program, of QP
                             ///< iterations
  double time_limit = 0.0;   ///< wall-clock limit in seconds; 0: none
  /// Exact or Gauss-Newton Hessian of the Lagrangian. If the program does not support the requested
  /// one, the exact one is used. If it supports neither, differences of first derivatives are used.
  Curvature curvature = Curvature::exact;
  /// Smallest eigenvalue after convexification, relative to the largest eigenvalue of its block.
  double convexity_floor = 1e-6;
  /// Largest change of a variable by the first SQP step of a cold start, in nominal magnitudes.
  /// Longer steps take durations to their bounds, close to other local optima.
  double initial_trust_radius = 1.0;
  QpMethod qp = sparse_qp();  ///< linear algebra of quadratic models and Newton systems
  /// Linear algebra of elastic mode. Its programs have two additional variables per row and no
  /// stages.
  QpMethod elastic_qp = sparse_qp();
};

/// The native solver: chooses the barrier method or sequential quadratic programming itself.
std::unique_ptr<Solver> make_native_solver(NativeSolverOptions options = {});

/// Deprecated name, removed in 0.4.
using SqpOptions [[deprecated("use NativeSolverOptions")]] = NativeSolverOptions;

[[deprecated("use make_native_solver")]] std::unique_ptr<Solver> make_sqp(
    NativeSolverOptions options = {});  ///< deprecated name, removed in 0.4

}  // namespace saltus
