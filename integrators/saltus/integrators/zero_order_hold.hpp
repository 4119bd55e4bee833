// Exact solution of an interval with affine dynamics, for linear MPC.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// Exact to rounding for time-invariant dynamics that are affine in (x, u) and time-invariant
/// running costs that are at most quadratic in (x, u). Parameters may enter both in any way. Both
/// input shapes are exact: a linear input is a ramp column, not sampled.
///
/// - Stores the matrices of the last few pairs (h, p): repeated pairs cost only multiplications.
/// - First derivatives with respect to all arguments, including parameters and length.
/// - has_hessian() is true unless parameters are differentiated. The Hessian includes the length.
///   With Curvature::gauss_newton, rows and columns of the length are zero.
/// - Does not allocate after construction.
///
/// make() throws DefinitionError with the offending pair of variables if a function has a different
/// form. It detects kinks, such as abs() in a formula, by comparing derivatives at random points.
/// Running costs of a different form, such as a time-varying reference, require
/// costs(CostRule::nodes) or another integrator.
IntegratorChoice zero_order_hold();

}  // namespace saltus
