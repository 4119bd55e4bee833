// Factories of integrators for intervals with events, and the error of schemes without events.
#pragma once

#include <memory>

#include "saltus/integrators/hybrid_integrator.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {

std::unique_ptr<Integrator> hybrid_runge_kutta(const IntervalProblem& problem,
                                               const ButcherTableau& tableau, int steps);
std::unique_ptr<Integrator> hybrid_implicit(const IntervalProblem& problem,
                                            const ButcherTableau& tableau, int steps);
struct CvodesOptions;  // sundials.hpp, component sundials
std::unique_ptr<Integrator> hybrid_cvodes(const IntervalProblem& problem,
                                          const CvodesOptions& options);
struct IdasOptions;  // sundials.hpp, component sundials
std::unique_ptr<Integrator> hybrid_idas(const IntervalProblem& problem, const IdasOptions& options);

/// For schemes without support for events: throws DefinitionError with a list of those that support
/// them.
void throw_no_event_support(const IntervalProblem& problem, const char* scheme);

}  // namespace saltus
