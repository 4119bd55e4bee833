// Explicit Runge-Kutta methods with a fixed number of equal steps and exact first and second
// derivatives of the discrete map. The choice for control loops.
#pragma once

#include <string>
#include <vector>

#include "saltus/model/integrator.hpp"

namespace saltus {

/// A Butcher tableau: X_i = x + step sum_j a_ij K_j, x+ = x + step sum_i b_i K_i.
struct ButcherTableau {
  std::string name;  ///< name for messages and results
  int order = 0;     ///< the local error is O(h^(order + 1))
  MatrixXd a;        ///< stages x stages; strictly lower triangular if explicit
  VectorXd b;        ///< weights of the stages
  VectorXd c;        ///< row sums of a

  /// Number of stages.
  int stages() const { return static_cast<int>(b.size()); }
};

/// Kutta 1901, the classical method: 4 stages, order 4.
ButcherTableau classical_runge_kutta();
/// Cooper and Verner 1972, closed form in sqrt(21): 11 stages, order 8.
ButcherTableau cooper_verner();

/// Options of explicit Runge-Kutta methods.
struct RungeKuttaOptions {
  int steps = 1;  ///< equal steps per interval
};

/// The classical method of order 4. First and second derivatives are those of the discrete map,
/// exact to rounding, also with respect to start time and length. Running costs use the same
/// stages. Curvature::gauss_newton is the sum of the costs' Gauss-Newton matrices along the stage
/// sensitivities. It omits terms in which the length multiplies a gradient, and is positive
/// semidefinite if the costs' matrices are. Does not allocate after construction. Throws
/// DefinitionError if steps < 1.
IntegratorChoice runge_kutta4(RungeKuttaOptions options = {});
/// A method of order 8 for smooth offline problems at tight tolerances. Not for formulas with
/// kinks.
IntegratorChoice runge_kutta8(RungeKuttaOptions options = {});
/// A method with a custom tableau. Throws DefinitionError if it is not explicit and consistent.
IntegratorChoice runge_kutta(ButcherTableau tableau, RungeKuttaOptions options = {});

}  // namespace saltus
