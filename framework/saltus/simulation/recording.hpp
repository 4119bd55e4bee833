// Trajectories as tables: states, inputs, modes and events over time, in the format that the plot
// scripts read.
#pragma once

#include <string>
#include <vector>

#include "saltus/model/event_integrator.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/trajectory.hpp"

namespace saltus {

struct Solution;

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
  /// Writes trajectory.csv and events.csv into the folder, which it creates. Throws InputError
  /// naming the file that cannot be written.
  void write(const std::string& folder) const;
};

/// Samples a plan. Its modes are the phases, and inside a phase those of its automaton or schedule.
/// Its events are the ends of phases and the events inside them.
Recording record(const OptimalControlProblem& problem, const Trajectory& trajectory,
                 int samples_per_interval = 8);

/// Writes trajectory.csv and events.csv of a plan, which `saltus plot FOLDER` draws. Creates the
/// folder. Names are as in a Recording, one per column, or none. Throws DefinitionError if their
/// number is wrong, and InputError naming the file that cannot be written.
///
///     save(problem, plan, "swing_up", {"angle [rad]", "rate [rad/s]"}, {"torque [Nm]"});
void save(const OptimalControlProblem& problem, const Trajectory& plan, const std::string& folder,
          std::vector<std::string> state_names = {}, std::vector<std::string> input_names = {});
/// The same for a solution.
void save(const OptimalControlProblem& problem, const Solution& plan, const std::string& folder,
          std::vector<std::string> state_names = {}, std::vector<std::string> input_names = {});

}  // namespace saltus
