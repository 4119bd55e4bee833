// How our own solvers do their linear algebra: on a sparse factor, or stage by stage.
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

/// Makes solvers of quadratic programs with given patterns, which are models of `program`, and of
/// Newton's equations with them. Tolerance and limit of iterations come from whom they are made
/// for. A function that makes a QpSolver is a method too, but one without Newton's equations: what
/// solves nonlinear programs with it then solves every model to its end.
struct QpMethod {
  /// Makes the solver of quadratic models.
  using MakeSolver = std::function<std::unique_ptr<QpSolver>(
      const NonlinearProgram& program, const SparsityPattern& hessian, const SparsityPattern& rows,
      const QpOptions& options)>;
  /// Makes what solves Newton systems of the barrier method.
  using MakeNewton = std::function<std::unique_ptr<NewtonSystem>(const NonlinearProgram& program,
                                                                 const SparsityPattern& hessian,
                                                                 const SparsityPattern& rows)>;

  QpMethod() = default;
  /// From both.
  QpMethod(MakeSolver solver, MakeNewton newton)
      : make_solver(std::move(solver)), make_newton(std::move(newton)) {}
  /// From what makes quadratic solvers; Newton systems are sparse then.
  template <class Make>
    requires std::constructible_from<MakeSolver, Make> &&
             (!std::same_as<std::remove_cvref_t<Make>, QpMethod>)
  QpMethod(Make&& make) : make_solver(std::forward<Make>(make)) {}  // NOLINT: as a function was

  /// Whether there is one.
  explicit operator bool() const { return static_cast<bool>(make_solver); }
  /// The solver of quadratic models of a program.
  std::unique_ptr<QpSolver> operator()(const NonlinearProgram& program,
                                       const SparsityPattern& hessian, const SparsityPattern& rows,
                                       const QpOptions& options) const {
    return make_solver(program, hessian, rows, options);
  }

  MakeSolver make_solver;  ///< of quadratic models
  MakeNewton make_newton;  ///< of Newton systems
  bool by_stages = false;  ///< it needs the rows that define the stages of the program
};

/// Sparse linear algebra, for every program.
QpMethod sparse_qp();
/// The structured solver, in the stages of the program; DefinitionError if it has none. Roll-out
/// comes from `options`, what QpOptions has from the caller. `kernels` must outlive the method.
QpMethod riccati_qp(RiccatiOptions options = {}, std::span<const qp::RiccatiKernel> kernels = {});

}  // namespace saltus
