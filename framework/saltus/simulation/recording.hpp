// What happened over time, or is planned to: states, inputs, modes and events as tables, in the one
// form that the scripts that draw read.
#pragma once

#include <string>
#include <vector>

#include "saltus/model/event_integrator.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/trajectory.hpp"

namespace saltus {

/// Values at one instant.
struct Sample {
  double time = 0.0;      ///< s
  VectorXd state, input;  ///< values
  std::string mode;       ///< empty where there is one only
};

/// A run in tables.
struct Recording {
  /// With their units: "height [m]". What is not named is x0, x1, ... and u0, u1, ...
  std::vector<std::string> state_names, input_names;
  /// Times do not decrease; an event appears twice, with the values before and after it.
  std::vector<Sample> samples;
  std::vector<HybridEvent> events;  ///< in the order of their times

  /// The names of all columns of states and of inputs.
  std::vector<std::string> state_columns() const;
  /// As the table heads them.
  std::vector<std::string> input_columns() const;
  /// "t [s]", mode, states, inputs; columns that a mode does not have are empty.
  std::string trajectory_csv() const;
  /// "t [s]", event, kind, and the modes before and after it.
  std::string events_csv() const;
};

/// A plan: its modes are the phases, inside a phase those of its automaton, or of the schedule; its
/// events are the ends of phases and what happens inside of them. Every shooting interval is
/// sampled so many times.
Recording record(const OptimalControlProblem& problem, const Trajectory& trajectory,
                 int samples_per_interval = 8);

}  // namespace saltus
