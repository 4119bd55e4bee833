#include "saltus/model/integrator.hpp"

#include <utility>

#include "saltus/core/error.hpp"

namespace saltus {

ReentrantIntegrator::ReentrantIntegrator(IntervalProblem problem, IntegratorChoice scheme)
    : problem_(std::move(problem)),
      scheme_(std::move(scheme)),
      interval_arguments_{problem_.arguments.nx, problem_.coefficients(), problem_.arguments.np} {
  if (!scheme_) throw DefinitionError("an integrator needs a scheme, but none is given");
}

IntegrationStatus ReentrantIntegrator::value(const double* w, double* end) const {
  return integrators_.lend([this] { return make(); })->value(w, end);
}

}  // namespace saltus
