// The derivative of an interval's flow along a direction, also where it has no Jacobian: where two
// events fall together the flow is only piecewise smooth, and which of them comes first depends on
// where one goes.
#pragma once

#include <string>

#include "saltus/model/integrator.hpp"

namespace saltus {

/// Derivative along one direction, from one side.
struct DirectionalDerivative {
  VectorXd value;       ///< d end / d epsilon at epsilon = 0+; NaN where it does not exist
  double error = 0.0;   ///< estimated, relative to 1 + the largest entry
  bool exists = false;  ///< whether there is one
  std::string message;  ///< why not, empty if it exists
};

/// lim (F(w + epsilon direction) - F(w)) / epsilon for epsilon -> 0 from above, F(w) the end of the
/// interval. The Jacobians at w + epsilon direction, where the events have an order, are
/// extrapolated: with epsilon = first_step, first_step / 2, ... `first_step` should be so short
/// that nothing else happens along it. Near grazing these grow without bound, and that is said.
/// Allocates; meant for analysis and design.
DirectionalDerivative directional_derivative(Integrator& integrator, const VectorRef& w,
                                             const VectorRef& direction, double first_step = 1e-3);

}  // namespace saltus
