// Directional derivatives of the flow of an interval, also where it has no Jacobian. Where two
// events coincide, the flow is only piecewise smooth: the direction decides which event comes
// first.
#pragma once

#include <string>

#include "saltus/model/integrator.hpp"

namespace saltus {

/// One-sided derivative along a direction.
struct DirectionalDerivative {
  VectorXd value;       ///< d end / d epsilon at epsilon = 0+; NaN where it does not exist
  double error = 0.0;   ///< estimate, relative to 1 + the largest entry
  bool exists = false;  ///< true if the derivative exists
  std::string message;  ///< the reason if it does not exist, else empty
};

/// Limit of (F(w + epsilon direction) - F(w)) / epsilon for epsilon -> 0+, where F(w) is the end of
/// the interval. Extrapolates the Jacobians at w + epsilon direction, where the order of events is
/// defined, with epsilon = first_step, first_step / 2, ... No other event may occur within
/// `first_step` along the direction. Near grazing, the Jacobians grow without bound and the message
/// says so. Allocates; intended for analysis and design.
DirectionalDerivative directional_derivative(Integrator& integrator, const VectorRef& w,
                                             const VectorRef& direction, double first_step = 1e-3);

}  // namespace saltus
