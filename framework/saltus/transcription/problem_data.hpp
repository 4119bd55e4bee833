// All data that may change between two solves of a transcribed problem, as one value.
#pragma once

#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/ocp/schedule.hpp"

namespace saltus {

/// Data of a solve. ShootingProgram::commit applies all of it or nothing.
struct ProblemData {
  double start_time = 0.0;              ///< absolute, s
  std::vector<Bounds> start_bounds;     ///< bounds of the first state; equal sides if it is fixed
  std::vector<double> durations;        ///< per phase, s; initial guess if free
  std::vector<Bounds> duration_bounds;  ///< per phase, s; ignored for fixed durations
  Bounds total_time;                    ///< s; used if the problem bounds it
  std::vector<VectorXd> parameters;     ///< p of each phase: data, and initial guesses of unknowns
  VectorXd previous_input;              ///< applied before the horizon; NaN: unknown, not charged
  Schedule schedule;                    ///< events and modes of the next solve

  ProblemData() = default;
  /// Data from the problem definition.
  explicit ProblemData(const OptimalControlProblem& problem);

  /// True if the first state is fixed.
  bool has_given_start() const;
  /// True if both give the same node times and the same bounds on durations.
  bool has_times_of(const ProblemData& other) const;
};

/// Throws DefinitionError with the item if a size is wrong, a number is invalid or an event of a
/// window is missing. Contradictory bounds are detected on the grid only. Does not allocate without
/// an error.
void check(const OptimalControlProblem& problem, const ProblemData& data);

}  // namespace saltus
