// The exact solution of an interval with affine dynamics: the scheme of linear MPC.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// Exact up to rounding for dynamics that are affine in (x, u) and do not depend on t, and for
/// running costs that are at most quadratic in (x, u) and do not depend on t; parameters may enter
/// both in any way. Both input shapes are exact (a linear one is a ramp column, not a sample).
///
/// - The matrices of the last few pairs (h, p) are kept: calls that repeat one only multiply.
/// - First derivatives with respect to everything, parameters and length included.
/// - has_hessian(): yes, with the length included, unless parameters are differentiated. Under
///   Curvature::gauss_newton rows and columns of the length are zero.
/// - Nothing allocates after construction.
///
/// make() throws DefinitionError with the offending pair of variables when a function has another
/// form. Kinks such as abs() in a formula are found by comparing derivatives at random points.
/// Running costs of another form, such as those of a reference that varies in time, need
/// costs(CostRule::nodes) or another integrator.
IntegratorChoice zero_order_hold();

}  // namespace saltus
