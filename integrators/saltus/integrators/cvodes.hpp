// CVODES: variable-order multistep integration with forward sensitivities under error control. The
// reference for stiff problems and for offline use.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// Multistep method.
enum class CvodesMethod {
  Bdf,   ///< stiff problems; Newton with the analytic Jacobian and a dense factorisation
  Adams  ///< non-stiff problems; fixed-point iteration
};

/// Coupling of states and sensitivities.
enum class CvodesSensitivity {
  staggered,    ///< accepts the state step first, then all sensitivities
  simultaneous  ///< corrects both together
};

/// Options of cvodes().
struct CvodesOptions {
  CvodesMethod method = CvodesMethod::Bdf;  ///< multistep method
  double tolerance = 1e-9;                  ///< relative, per local step
  /// Absolute tolerance, multiplied by the nominal magnitude of each state
  /// (IntervalProblem::nominal_state). For the sensitivity to w_j it is also divided by the
  /// magnitude of w_j. For parameters, this is their value.
  double absolute_tolerance = 1e-12;
  CvodesSensitivity sensitivity = CvodesSensitivity::staggered;  ///< coupling of sensitivities
  long max_steps = 100000;                                       ///< per interval
};

/// Integrates the interval in scaled time with running costs as additional states. Sensitivities
/// are included in error control. value() omits them and may take other steps than jacobian(), so
/// their end states agree to the tolerance, not to the last digit. The global error is typically 10
/// to 100 times the tolerance. Does not allocate after the first call of each kind, unless the
/// magnitude of a parameter or the length changes by a factor of two. There are no second
/// derivatives. Throws DefinitionError for a tolerance outside (0, 1) or a negative absolute one.
IntegratorChoice cvodes(CvodesOptions options = {});

}  // namespace saltus
