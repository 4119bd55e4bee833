// An integrator for concurrent use by any number of threads.
#pragma once

#include <memory>

#include "saltus/core/workspace_pool.hpp"
#include "saltus/model/integrator.hpp"

namespace saltus {

/// Integrates intervals of one problem with one scheme. Const and re-entrant: each call borrows an
/// Integrator from a pool. A call allocates if none is free, so use it offline.
class ReentrantIntegrator {
 public:
  /// Throws DefinitionError if the scheme is null. The first call reports a scheme that does not
  /// fit the problem; IntegratorScheme::make() reports it earlier.
  ReentrantIntegrator(IntervalProblem problem, IntegratorChoice scheme);

  /// The problem that it integrates.
  const IntervalProblem& problem() const { return problem_; }
  /// Layout and sizes of the argument w.
  IntervalArguments arguments() const { return interval_arguments_; }
  /// Number of results: states at the end, then running costs.
  int outputs() const { return problem_.arguments.nx + problem_.nq(); }
  /// Same as Integrator::value().
  IntegrationStatus value(const double* w, double* end) const;
  /// Creates an Integrator of the same problem and scheme, for one thread.
  std::unique_ptr<Integrator> make() const { return scheme_->make(problem_); }

 private:
  IntervalProblem problem_;
  IntegratorChoice scheme_;
  IntervalArguments interval_arguments_;
  WorkspacePool<Integrator> integrators_;
};

}  // namespace saltus
