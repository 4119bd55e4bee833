// Functions composed of functions. They transform a problem whose formulas are type-erased.
#pragma once

#include <vector>

#include "saltus/model/function.hpp"

namespace saltus::metamorphic {

/// rows .* f(columns .* z): the same formula in other units. At most 256 arguments and outputs.
Function scaled(const Function& f, const VectorXd& columns, const VectorXd& rows);
/// A scalar: offset + sum of weights .* z.
Function affine(const VectorXd& weights, double offset);

}  // namespace saltus::metamorphic
