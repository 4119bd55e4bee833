// The schemes that integrate intervals with events, and the refusal of the others.
#pragma once

#include <memory>

#include "saltus/integrators/hybrid_integrator.hpp"
#include "saltus/integrators/runge_kutta.hpp"

namespace saltus {

std::unique_ptr<Integrator> hybrid_runge_kutta(const IntervalProblem& problem,
                                               const ButcherTableau& tableau, int steps);
std::unique_ptr<Integrator> hybrid_implicit(const IntervalProblem& problem,
                                            const ButcherTableau& tableau, int steps);
struct CvodesOptions;  // cvodes.hpp, of the component sundials
std::unique_ptr<Integrator> hybrid_cvodes(const IntervalProblem& problem,
                                          const CvodesOptions& options);
struct IdasOptions;  // idas.hpp, of the component sundials
std::unique_ptr<Integrator> hybrid_idas(const IntervalProblem& problem, const IdasOptions& options);

/// For schemes that do not integrate events. Throws DefinitionError naming those that do.
void refuse_events(const IntervalProblem& problem, const char* scheme);

}  // namespace saltus
