// Explicit Runge-Kutta with a fixed number of equal steps, with exact derivatives of first and
// second order of the discrete map. The scheme for the control loop.
#pragma once

#include <string>
#include <vector>

#include "saltus/model/integrator.hpp"

namespace saltus {

/// A Butcher tableau: X_i = x + step sum_j a_ij K_j, x+ = x + step sum_i b_i K_i.
struct ButcherTableau {
  std::string name;  ///< for messages and results
  int order = 0;     ///< the error of one step is O(h^(order + 1))
  MatrixXd a;        ///< stages x stages; of explicit schemes strictly lower triangular
  VectorXd b;        ///< weights of the stages
  VectorXd c;        ///< row sums of a

  /// How many.
  int stages() const { return static_cast<int>(b.size()); }
};

/// Kutta 1901, the classical method: 4 stages, order 4.
ButcherTableau classical_runge_kutta();
/// Cooper and Verner 1972, closed form in sqrt(21): 11 stages, order 8.
ButcherTableau cooper_verner();

/// What integrates by a chain of explicit steps.
struct RungeKuttaOptions {
  int steps = 1;  ///< equal steps per interval
};

/// Derivatives of first and second order are those of the discrete map, exact up to rounding,
/// including those with respect to start time and length; running costs use the same stages.
/// Curvature::gauss_newton is the sum of the costs' own matrices along the stage sensitivities,
/// without the terms in which the length multiplies a gradient: positive semidefinite if they are.
/// Nothing allocates after construction. Throws DefinitionError if steps < 1.
IntegratorChoice runge_kutta4(RungeKuttaOptions options = {});
/// For smooth offline problems at tight tolerance; not for formulas with kinks.
IntegratorChoice runge_kutta8(RungeKuttaOptions options = {});
/// With a tableau of your own. Throws DefinitionError when it is not explicit and consistent.
IntegratorChoice runge_kutta(ButcherTableau tableau, RungeKuttaOptions options = {});

}  // namespace saltus
