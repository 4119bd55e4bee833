// Step program for one number of steps, solved repeatedly: real-time iterations with the structured
// solver, each tick from the previous plan.
#pragma once

#include <array>
#include <memory>

#include "problems/push_recovery/step_problem.hpp"
#include "saltus/mpc/real_time_iteration.hpp"
#include "saltus/robots/walking/step_planner.hpp"
#include "saltus/solver/optimum_check.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::push_recovery {

/// A plan in the frame of StepNow; times in s from the tick.
struct StepSolution {
  bool is_solved = false;      ///< true if a plan within `feasible` of its constraints was found
  double cost = infinity;      ///< cost including penalties
  double missed = infinity;    ///< total violation of penalised constraints, m
  double residual = infinity;  ///< largest violation of a hard row or bound, in scaled variables
  int iterations = 0;          ///< quadratic programs
  int steps = 0;
  std::array<double, most_planned_steps> lift_off{}, landing{};
  std::array<Vec<double, 2>, most_planned_steps> place;  ///< centres of the soles, m
  /// First interval: centre of pressure in the standing sole, m, and rate of eta, m/s.
  Vec<double, 2> pressure = Vec<double, 2>::Zero(), lent_rate = Vec<double, 2>::Zero();
};

/// Grid of step_problem().
ShootingOptions step_grid(const OptimalControlProblem& problem);

class StepProgram {
 public:
  StepProgram(const StepModel& model, int steps, bool from_two_feet);

  int steps() const { return steps_; }
  /// Last solved program, with its data.
  const MultipleShooting& shooting() const { return *shooting_; }
  /// Makes the next solve start from the problem's own guess.
  void restart() { has_plan_ = false; }
  /// Solves from `state` (StepModel), `elapsed` s after the previous solve. `first` bounds the
  /// remaining duration of the first phase, s. Solves at most `most_iterations` quadratic programs
  /// and stops when the plan no longer changes. Does not allocate.
  const StepSolution& solve(const StepNow<double>& now, const Vec<double, step_states>& state,
                            Bounds first, double elapsed, int most_iterations) noexcept;
  /// Samples the first seconds of the last solution, simulated from its start with the planned
  /// inputs, in the frame of StepNow. Does not allocate.
  void sample(walking::StepPlan::Motion& motion) const;
  /// The plan of the last solution, with its costs by name. Allocates.
  Solution report();

 private:
  void read_solution();
  void begin_at(double elapsed, Bounds first);
  SupportedSole<double> sole(int k) const;
  Vec<double, 2> pressure_at(double time) const;

  int steps_;
  bool from_two_feet_;
  StepModel model_;
  std::unique_ptr<MultipleShooting> shooting_;
  std::unique_ptr<RealTimeSolver> solver_;
  KktCheck check_;
  NlpPoint initial_, plan_, before_;
  StepNow<double> now_;  // of the last solution
  Vec<double, step_states> state_ = Vec<double, step_states>::Zero();
  bool has_plan_ = false, has_multipliers_ = false;
  StepSolution solution_;
};

}  // namespace saltus::push_recovery
