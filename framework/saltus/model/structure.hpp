// Structural properties of a function from its sparsity: dependence on inputs and affinity.
#pragma once

#include <vector>

#include "saltus/autodiff/tracer.hpp"
#include "saltus/core/sparsity.hpp"
#include "saltus/model/function.hpp"

namespace saltus {

/// Sparsity patterns of a formula, found by one trace.
struct FormulaStructure {
  SparsityPattern jacobian;                ///< outputs x inputs
  SparsityPattern hessian;                 ///< inputs x inputs, lower triangle, of any output
  std::vector<SparsityPattern> curvature;  ///< per output: its part of `hessian`
};
/// Patterns of traced outputs.
FormulaStructure structure_of(int inputs, const std::vector<Tracer>& outputs);

/// True if any output may depend on the input.
bool depends_on(const Function& function, int input);
/// True if this output may depend on the input.
bool depends_on(const Function& function, int output, int input);
/// True if any output may depend on one of the inputs z[first .. first + count).
bool depends_on_any(const Function& function, int first, int count);

/// True if all outputs are jointly affine in z[first .. first + count) with the other inputs fixed,
/// i.e. no second derivatives within this range. The slopes may depend on the other inputs.
bool is_affine_in(const Function& function, int first, int count);

}  // namespace saltus
