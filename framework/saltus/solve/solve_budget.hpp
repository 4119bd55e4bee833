// The solves of one explanation: they share grid options, one deadline and a counter.
#pragma once

#include <functional>

#include "saltus/core/clock.hpp"
#include "saltus/solve/explain.hpp"
#include "saltus/solve/least_relaxation.hpp"

namespace saltus {

/// Relaxes and solves problems with the given options.
class SolveBudget {
 public:
  /// Starts the clock.
  explicit SolveBudget(const ExplainOptions& options);

  /// Selects what least_relaxation() may relax; empty: everything negotiable.
  std::function<bool(const NegotiableConstraint&)> is_negotiable = {};

  /// Computes the least relaxation, from the guess or by default from the problem's own guess.
  LeastRelaxation relax(const OptimalControlProblem& problem, const Trajectory* guess = nullptr) {
    return relax(problem, guess, grid());
  }
  /// The same on another grid.
  LeastRelaxation relax(const OptimalControlProblem& problem, const Trajectory* guess,
                        const ShootingOptions& grid);
  /// Solves from the problem's own guess and, if that fails, from the other guess.
  Solution plan(MultipleShooting& shooting, const Trajectory& other_guess);

  /// True if ExplainOptions::may_change permits the change.
  bool may_change(const ProblemChange& change) const {
    return !options_.may_change || options_.may_change(change);
  }
  /// Options of new shootings.
  const ShootingOptions& grid() const { return options_.shooting; }
  /// True if the time limit has passed. Later solves then end at once.
  bool is_late() const { return WallClock::now() >= deadline_; }
  int count() const { return count_; }                      ///< number of solves
  double seconds() const { return seconds_since(begin_); }  ///< wall-clock time so far

 private:
  std::unique_ptr<Solver> make_solver() const;

  ExplainOptions options_;
  WallClock::time_point begin_ = WallClock::now(), deadline_ = WallClock::time_point::max();
  int count_ = 0;
};

/// True if a solution is an optimum, even if its grid is too coarse.
bool is_plan(const Solution& solution);

}  // namespace saltus
