// Trajectories as tables: states, inputs, modes and events over time, in the format that the plot
// scripts read.
#pragma once

#include <string>
#include <vector>

#include "saltus/model/event_integrator.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/trajectory.hpp"

namespace saltus {

/// Values at one instant.
struct Sample {
  double time = 0.0;      ///< time in seconds
  VectorXd state, input;  ///< values
  std::string mode;       ///< empty if there is only one
};

/// A recorded run.
struct Recording {
  /// Names with units: "height [m]". The defaults are x0, x1, ... and u0, u1, ...
  std::vector<std::string> state_names, input_names;
  /// Times do not decrease. An event has two samples, with the values before and after it.
  std::vector<Sample> samples;
  std::vector<HybridEvent> events;  ///< events in order of time

  /// Column names of the states.
  std::vector<std::string> state_columns() const;
  /// Column names of the inputs.
  std::vector<std::string> input_columns() const;
  /// "t [s]", mode, states, inputs. Columns that a mode does not have are empty.
  std::string trajectory_csv() const;
  /// "t [s]", event, kind, and the modes before and after it.
  std::string events_csv() const;
};

/// Samples a plan. Its modes are the phases, and inside a phase those of its automaton or schedule.
/// Its events are the ends of phases and the events inside them.
Recording record(const OptimalControlProblem& problem, const Trajectory& trajectory,
                 int samples_per_interval = 8);

}  // namespace saltus
