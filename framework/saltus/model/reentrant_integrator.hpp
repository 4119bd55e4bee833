// An integrator as a value: what is integrated and how, for any number of threads at once.
#pragma once

#include <memory>

#include "saltus/core/workspace_pool.hpp"
#include "saltus/model/integrator.hpp"

namespace saltus {

/// Integrates intervals of one problem by one scheme. Const and re-entrant: each call works with an
/// Integrator of its own, which is kept for later calls. For offline use: a call makes an
/// Integrator, and so allocates, where none is free.
class ReentrantIntegrator {
 public:
  /// Throws DefinitionError if there is no scheme. Whether it fits the problem is found by the
  /// first call; IntegratorScheme::make() says so earlier.
  ReentrantIntegrator(IntervalProblem problem, IntegratorChoice scheme);

  /// What it integrates.
  const IntervalProblem& problem() const { return problem_; }
  /// Sizes of what it takes.
  IntervalArguments arguments() const { return interval_arguments_; }
  /// States at the end, then running costs.
  int outputs() const { return problem_.arguments.nx + problem_.nq(); }
  /// As Integrator::value().
  IntegrationStatus value(const double* w, double* end) const;
  /// A new Integrator of the same problem and scheme, for one thread.
  std::unique_ptr<Integrator> make() const { return scheme_->make(problem_); }

 private:
  IntervalProblem problem_;
  IntegratorChoice scheme_;
  IntervalArguments interval_arguments_;
  WorkspacePool<Integrator> integrators_;
};

}  // namespace saltus
