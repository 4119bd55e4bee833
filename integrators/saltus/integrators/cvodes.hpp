// CVODES: variable-order multistep integration with forward sensitivities under error control.
// The reference for stiff and offline problems.
#pragma once

#include "saltus/model/integrator.hpp"

namespace saltus {

/// For stiff fields (BDF) or others (Adams).
enum class CvodesMethod {
  Bdf,   ///< stiff problems; Newton with the analytic Jacobian and a dense factorisation
  Adams  ///< non-stiff problems; fixed-point iteration
};

/// How CVODES integrates states and sensitivities together.
enum class CvodesSensitivity {
  staggered,    ///< state step accepted first, then all sensitivities
  simultaneous  ///< both corrected together
};

/// What integrates with CVODES.
struct CvodesOptions {
  CvodesMethod method = CvodesMethod::Bdf;  ///< for stiff fields or others
  double tolerance = 1e-9;                  ///< relative, on each local step
  /// Absolute, times the nominal magnitude of each state (IntervalProblem::nominal_state).
  /// The sensitivity to w_j has this divided by the magnitude of w_j (parameters: their value).
  double absolute_tolerance = 1e-12;
  CvodesSensitivity sensitivity = CvodesSensitivity::staggered;  ///< how sensitivities join
  long max_steps = 100000;                                       ///< per interval
};

/// The interval is integrated in scaled time with running costs as additional states. Sensitivities
/// take part in the error control, so that value() (without them) and jacobian() may take
/// different steps: their end states agree within the tolerance, not to the last digit. The global
/// error is typically 10 to 100 times the tolerance. No allocation after the first call of each
/// kind, except where the magnitude of a parameter or the length doubles or halves. No second
/// derivatives. Throws DefinitionError for a tolerance outside (0, 1) or a negative absolute one.
IntegratorChoice cvodes(CvodesOptions options = {});

}  // namespace saltus
