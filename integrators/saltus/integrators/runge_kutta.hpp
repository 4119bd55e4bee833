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
  int steps = 1;  ///< equal steps per interval, at most 1,000,000
};

/// The classical method of order 4. First and second derivatives are those of the discrete map,
/// exact to rounding, also with respect to start time and length. Running costs use the same
/// stages. Curvature::gauss_newton is the sum of the costs' Gauss-Newton matrices along the stage
/// sensitivities. It omits terms in which the length multiplies a gradient, and is positive
/// semidefinite if the costs' matrices are. Does not allocate after construction. Throws
/// DefinitionError if the number of steps is out of range.
IntegratorChoice runge_kutta4(RungeKuttaOptions options = {});
/// A method of order 8 for smooth offline problems at tight tolerances. Not for formulas with
/// kinks.
IntegratorChoice runge_kutta8(RungeKuttaOptions options = {});
/// A method with a custom tableau. Throws DefinitionError if it is not explicit and consistent.
IntegratorChoice runge_kutta(ButcherTableau tableau, RungeKuttaOptions options = {});

// Implicit Runge-Kutta methods by collocation with a fixed number of equal steps and exact first
// and second derivatives of the discrete map. For stiff dynamics and for few long steps.

/// Options of implicit Runge-Kutta methods.
struct ImplicitRungeKuttaOptions {
  int stages = 2;  ///< 1 to 4
  int steps = 1;   ///< equal steps per interval, at most 1,000,000
};

/// Gauss-Legendre collocation of order 2 * stages. A-stable and symmetric; preserves quadratic
/// invariants, so oscillations neither grow nor decay. Very stiff components oscillate instead of
/// decaying. With one stage it is the implicit midpoint rule.
///
/// Newton's method solves the stages of each step to rounding. Derivatives are those of this map by
/// the implicit function theorem, also with respect to start time and length. If Newton's method
/// fails, the status is IntegrationStatus::step_too_small and failure() names the step. Does not
/// allocate after construction. Supports events inside an interval (framework/design/events.md).
/// Throws DefinitionError for other numbers of stages and of steps.
IntegratorChoice gauss_legendre(ImplicitRungeKuttaOptions options = {});

/// Radau IIA collocation of order 2 * stages - 1, otherwise as above. L-stable: components faster
/// than the step decay within it. For stiff dynamics. With one stage it is the backward Euler
/// method.
IntegratorChoice radau_iia(ImplicitRungeKuttaOptions options = {});

/// Tableau of Gauss-Legendre collocation. The nodes are the zeros of the Legendre polynomial P_s on
/// [0, 1].
ButcherTableau gauss_legendre_tableau(int stages);
/// Tableau of Radau IIA of order 2 * stages - 1, stiffly accurate. The nodes are the zeros of P_s -
/// P_(s-1), of which the last is 1.
ButcherTableau radau_iia_tableau(int stages);

// The implicit midpoint rule with a fixed number of equal steps. Order 2, for stiff dynamics and
// for oscillations without numerical growth or damping.

/// Options of implicit_midpoint().
struct ImplicitMidpointOptions {
  int steps = 1;  ///< equal steps per interval
};

/// A-stable and symmetric; preserves quadratic invariants. Newton's method solves X = x + step/2
/// f(X) in each step to rounding. First and second derivatives are those of this map, by the
/// implicit function theorem. A failed step gives IntegrationStatus::step_too_small. Does not
/// allocate after construction. Throws DefinitionError if steps < 1, and for intervals with events.
IntegratorChoice implicit_midpoint(ImplicitMidpointOptions options = {});

}  // namespace saltus
