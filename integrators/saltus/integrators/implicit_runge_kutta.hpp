// Implicit Runge-Kutta by collocation with a fixed number of equal steps, with exact derivatives of
// first and second order of the discrete map: for stiff dynamics, and for few long steps.
#pragma once

#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {

/// What integrates by an implicit Runge-Kutta scheme.
struct ImplicitRungeKuttaOptions {
  int stages = 2;  ///< 1 to 4
  int steps = 1;   ///< equal steps per interval
};

/// Order 2 stages; A-stable. Keeps quadratic invariants and is its own inverse, so that what
/// oscillates neither grows nor decays; what is very stiff rings instead of settling. One stage is
/// the implicit midpoint rule.
///
/// Each step solves its stages by Newton's method to rounding. Derivatives are those of the map so
/// defined, by the implicit function theorem, with respect to start time and length too. Stages
/// that are not found are IntegrationStatus::step_too_small, with the step in failure(). Nothing
/// allocates after construction. Events inside an interval are handled
/// (framework/design/events.md). Throws DefinitionError for other numbers of stages, and if steps
/// < 1.
IntegratorChoice gauss_legendre(ImplicitRungeKuttaOptions options = {});

/// Order 2 stages - 1, in all else as above; L-stable: what is faster than the step is settled
/// within it. For stiff dynamics. One stage is the backward Euler method.
IntegratorChoice radau_iia(ImplicitRungeKuttaOptions options = {});

/// Their coefficients: the collocation methods at the zeros of the Legendre polynomial P_s of
/// [0, 1], and at those of P_s - P_(s-1), of which the last is 1.
ButcherTableau gauss_legendre_tableau(int stages);
/// Radau IIA of order 2 stages - 1, stiffly accurate; the last node is the end of the step.
ButcherTableau radau_iia_tableau(int stages);

}  // namespace saltus
