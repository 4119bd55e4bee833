// What the sparsity of a function says about it: on which inputs it depends, and in which it is
// affine.
#pragma once

#include <vector>

#include "saltus/autodiff/tracer.hpp"
#include "saltus/core/sparsity.hpp"
#include "saltus/model/function.hpp"

namespace saltus {

/// The patterns of a formula, found by tracing it once.
struct FormulaStructure {
  SparsityPattern jacobian;                ///< outputs x inputs
  SparsityPattern hessian;                 ///< inputs x inputs, lower triangle, of any output
  std::vector<SparsityPattern> curvature;  ///< per output: its part of `hessian`
};
/// Which entries its derivatives have, of which degree its outputs are.
FormulaStructure structure_of(int inputs, const std::vector<Tracer>& outputs);

/// Whether any output, or the given one, can change with the input.
bool depends_on(const Function& function, int input);
/// Whether any value of the input changes the output.
bool depends_on(const Function& function, int output, int input);
/// Whether any output can change with one of the inputs z[first .. first + count).
bool depends_on_any(const Function& function, int first, int count);

/// Whether all outputs are affine in z[first .. first + count) jointly, the other inputs held: no
/// two of these inputs (nor one with itself) interact. The slopes may depend on the others.
bool is_affine_in(const Function& function, int first, int count);

}  // namespace saltus
