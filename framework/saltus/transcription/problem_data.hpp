// What may change between two solves of a transcribed problem, as one value.
#pragma once

#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/ocp/schedule.hpp"

namespace saltus {

/// Data of a solve. A program takes it on whole or not at all (ShootingProgram::commit).
struct ProblemData {
  double start_time = 0.0;              ///< absolute, s
  std::vector<Bounds> start_bounds;     ///< of the first state; equal sides where it is given
  std::vector<double> durations;        ///< per phase, s; of a free one its guess, which stays
  std::vector<Bounds> duration_bounds;  ///< per phase, s; of fixed ones they are not read
  Bounds total_time;                    ///< s; read where the problem bounds it
  std::vector<VectorXd> parameters;     ///< p of each phase: data, and guesses of unknowns
  VectorXd previous_input;              ///< applied before the horizon; NaN: not known, not charged
  Schedule schedule;                    ///< of events and modes, in force for the next solve

  ProblemData() = default;
  /// What the problem's definition says.
  explicit ProblemData(const OptimalControlProblem& problem);

  /// Whether the first state is data.
  bool has_given_start() const;
  /// Whether both put the nodes at the same times, and leave them as much room.
  bool has_times_of(const ProblemData& other) const;
};

/// Sizes, numbers that are none, events that windows name: throws DefinitionError saying which.
/// Bounds that exclude one another show only on the grid. Allocates nothing if nothing is wrong.
void check(const OptimalControlProblem& problem, const ProblemData& data);

}  // namespace saltus
