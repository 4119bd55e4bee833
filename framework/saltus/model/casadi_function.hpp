// Functions that CasADi generated as C code, compiled into a shared library.
//
// A function f(t, x, u, p) or f(t, x, u) or f(t, x) needs two companions in the same file, whose
// inputs are those of f:
//
//     z = vertcat(t, x, u, p); w = SX.sym("w", y.numel())
//     f = Function("f", [t, x, u, p], [y])
//     J = Function("f_jacobian", [t, x, u, p], [y, jacobian(y, z)])
//     H = Function("f_hessian", [t, x, u, p, w], [tril(hessian(dot(w, y), z)[0])])
//     C = CodeGenerator("f.c"); [C.add(g) for g in (f, J, H)]; C.generate()
//
// saltus_casadi(NAME f.c) in CMake compiles the file. The companions are required: without exact
// derivatives and their sparsity, solvers converge slowly or not at all.
#pragma once

#include <string>

#include "saltus/model/function.hpp"

namespace saltus {

/// Loads the function `name` of a shared library, for z = (t | x | u | p) of these sizes. The
/// function may have fewer inputs than (t, x, u, p); their order is fixed. The library stays
/// loaded. Evaluation is re-entrant and writes NaN if the generated code reports a failure. Throws
/// InputError if the library cannot be loaded or lacks a function, and DefinitionError with input
/// and sizes if the function does not fit.
Function load_casadi(const std::string& library, const std::string& name, const Arguments& sizes);

}  // namespace saltus
