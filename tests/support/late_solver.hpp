// A real-time solver that misses its deadline in chosen ticks. It tests the reaction of a
// controller without a slow machine.
#pragma once

#include <functional>
#include <memory>
#include <string>
#include <utility>

#include "saltus/core/clock.hpp"
#include "saltus/mpc/real_time_iteration.hpp"

namespace saltus {

/// Wraps the given solver and reports a missed deadline in each solve for which `is_late` is true.
/// Solves count from 0.
class LateSolver final : public RealTimeSolver {
 public:
  LateSolver(std::unique_ptr<RealTimeSolver> solver, std::function<bool(long solve)> is_late)
      : solver_(std::move(solver)), is_late_(std::move(is_late)) {}
  void prepare(NonlinearProgram& program, const NlpPoint& guess) noexcept override {
    solver_->prepare(program, guess);
  }
  RealTimeSolver::Result feedback(NonlinearProgram& program, NlpPoint& point, bool warm,
                                  WallClock::time_point deadline) noexcept override {
    return solver_->feedback(program, point, warm,
                             is_late_(solves_++) ? WallClock::now() : deadline);
  }
  std::string name() const override { return solver_->name(); }

 private:
  std::unique_ptr<RealTimeSolver> solver_;
  std::function<bool(long)> is_late_;
  long solves_ = 0;
};

}  // namespace saltus
