// The solves of one explanation: on one kind of grid, with one deadline, counted.
#pragma once

#include <functional>

#include "saltus/core/clock.hpp"
#include "saltus/solve/explain.hpp"
#include "saltus/solve/least_relaxation.hpp"

namespace saltus {

/// Relaxes and solves problems as the options say.
class CountedSolves {
 public:
  /// The time begins to run.
  explicit CountedSolves(const ExplainOptions& options);

  /// What least_relaxation() may relax; empty: all that is asked for.
  std::function<bool(const AskedFor&)> is_negotiable = {};

  /// The least relaxation, from the guess or else from the problem's own.
  LeastRelaxation relax(const OptimalControlProblem& problem, const Trajectory* guess = nullptr) {
    return relax(problem, guess, grid());
  }
  /// The same on another grid.
  LeastRelaxation relax(const OptimalControlProblem& problem, const Trajectory* guess,
                        const ShootingOptions& grid);
  /// A solution: from the problem's own guess and, if that leads nowhere, from the other one.
  Solution plan(MultipleShooting& shooting, const Trajectory& other_guess);

  /// ExplainOptions::may_change.
  bool may_change(const ProblemChange& change) const {
    return !options_.may_change || options_.may_change(change);
  }
  /// Of new shootings.
  const ShootingOptions& grid() const { return options_.shooting; }
  /// Whether the time is over: what is solved later ends at once.
  bool is_late() const { return WallClock::now() >= deadline_; }
  int count() const { return count_; }                      ///< of solves
  double seconds() const { return seconds_since(begin_); }  ///< wall clock, so far

 private:
  std::unique_ptr<Solver> make_solver() const;

  ExplainOptions options_;
  WallClock::time_point begin_ = WallClock::now(), deadline_ = WallClock::time_point::max();
  int count_ = 0;
};

/// Whether a plan is one that could be driven: an optimum, whatever its grid leaves open.
bool is_plan(const Solution& solution);

}  // namespace saltus
