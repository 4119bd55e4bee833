// How our own solvers solve the quadratic programs inside: on a sparse factor, or stage by stage.
#pragma once

#include <functional>
#include <memory>
#include <span>

#include "saltus/qp/riccati_solver.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Makes a solver of quadratic programs with these patterns, which are models of `program`.
/// Tolerance and limit of iterations come from whom the solver is made for.
using QpMethod = std::function<std::unique_ptr<QpSolver>(
    const NonlinearProgram& program, const SparsityPattern& hessian, const SparsityPattern& rows,
    const QpOptions& options)>;

/// Sparse linear algebra, for every program.
QpMethod sparse_qp();
/// The structured solver, in the stages of the program; DefinitionError if it has none. Roll-out
/// comes from `options`, what QpOptions has from the caller. `kernels` must outlive the method.
QpMethod riccati_qp(RiccatiOptions options = {}, std::span<const qp::RiccatiKernel> kernels = {});

}  // namespace saltus
