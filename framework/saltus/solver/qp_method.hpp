// Linear algebra of the native solvers: sparse factorisation or stage by stage.
#pragma once

#include <concepts>
#include <functional>
#include <memory>
#include <span>
#include <utility>

#include "saltus/qp/newton_system.hpp"
#include "saltus/qp/riccati_solver.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Factory of solvers for the quadratic models of `program` and for its Newton systems. The caller
/// supplies tolerance and iteration limit. A function that makes a QpSolver is also a method, but
/// without Newton systems. Nonlinear solvers then solve every model to convergence.
struct QpMethod {
  /// Creates the solver of quadratic models.
  using MakeSolver = std::function<std::unique_ptr<QpSolver>(
      const NonlinearProgram& program, const SparsityPattern& hessian, const SparsityPattern& rows,
      const QpOptions& options)>;
  /// Creates the Newton system of the barrier method.
  using MakeNewton = std::function<std::unique_ptr<NewtonSystem>(const NonlinearProgram& program,
                                                                 const SparsityPattern& hessian,
                                                                 const SparsityPattern& rows)>;

  QpMethod() = default;
  /// Method with both factories.
  QpMethod(MakeSolver solver, MakeNewton newton)
      : make_solver(std::move(solver)), make_newton(std::move(newton)) {}
  /// Method from a factory of QP solvers alone; Newton systems are sparse.
  template <class Make>
    requires std::constructible_from<MakeSolver, Make> &&
             (!std::same_as<std::remove_cvref_t<Make>, QpMethod>)
  QpMethod(Make&& make) : make_solver(std::forward<Make>(make)) {}  // NOLINT: as a function was

  /// True if a factory is set.
  explicit operator bool() const { return static_cast<bool>(make_solver); }
  /// Creates the solver of quadratic models of a program.
  std::unique_ptr<QpSolver> operator()(const NonlinearProgram& program,
                                       const SparsityPattern& hessian, const SparsityPattern& rows,
                                       const QpOptions& options) const {
    return make_solver(program, hessian, rows, options);
  }

  MakeSolver make_solver;  ///< factory for quadratic models
  MakeNewton make_newton;  ///< factory for Newton systems
  bool by_stages = false;  ///< true if it needs the rows that define the stages of the program
};

/// Sparse linear algebra for any program.
QpMethod sparse_qp();
/// The structured solver on the stages of the program. Throws DefinitionError if the program has
/// none. Roll-out comes from `options`, the fields of QpOptions from the caller. `kernels` must
/// outlive the method.
QpMethod riccati_qp(RiccatiOptions options = {}, std::span<const qp::RiccatiKernel> kernels = {});

}  // namespace saltus
