// A solver is watched for a while.
#pragma once

#include <utility>

#include "saltus/solver/solver.hpp"

namespace saltus {

/// While it lives the solver has this observer, then the one before again, whatever was thrown.
class ScopedObserver {
 public:
  /// The solver outlives it.
  ScopedObserver(Solver& solver, SolveObserver observer)
      : solver_(&solver), before_(solver.observer()) {
    solver.set_observer(std::move(observer));
  }
  ~ScopedObserver() { solver_->set_observer(before_); }
  ScopedObserver(const ScopedObserver&) = delete;
  ScopedObserver& operator=(const ScopedObserver&) = delete;

 private:
  Solver* solver_;
  SolveObserver before_;
};

}  // namespace saltus
