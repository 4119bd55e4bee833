// Implicit Runge-Kutta methods by collocation with a fixed number of equal steps and exact first
// and second derivatives of the discrete map. For stiff dynamics and for few long steps.
#pragma once

#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {

/// Options of implicit Runge-Kutta methods.
struct ImplicitRungeKuttaOptions {
  int stages = 2;  ///< 1 to 4
  int steps = 1;   ///< equal steps per interval
};

/// Gauss-Legendre collocation of order 2 * stages. A-stable and symmetric; preserves quadratic
/// invariants, so oscillations neither grow nor decay. Very stiff components oscillate instead of
/// decaying. With one stage it is the implicit midpoint rule.
///
/// Newton's method solves the stages of each step to rounding. Derivatives are those of this map by
/// the implicit function theorem, also with respect to start time and length. If Newton's method
/// fails, the status is IntegrationStatus::step_too_small and failure() names the step. Does not
/// allocate after construction. Supports events inside an interval (framework/design/events.md).
/// Throws DefinitionError for other numbers of stages and if steps < 1.
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

}  // namespace saltus
