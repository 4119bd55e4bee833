// Sets the observer of a solver for a scope.
#pragma once

#include <utility>

#include "saltus/solver/solver.hpp"

namespace saltus {

/// Sets the observer and restores the previous one on destruction, also after an exception.
class ScopedObserver {
 public:
  /// The solver must outlive this object.
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
