// Log of a closed-loop run: motion of the plant, ticks of the controller, plans and events.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/simulation/loop_misses.hpp"
#include "saltus/simulation/recording.hpp"

namespace saltus {

/// A tick of the controller: its measurement and its answer.
struct LoopTick {
  double time = 0.0;  ///< start of the tick in seconds
  VectorXd measured;  ///< the state with noise and delay
  /// Source of the input; empty for a feedback law, whose following fields are unset too.
  std::optional<Provenance> provenance;
  SolveStatus status = SolveStatus::invalid_problem;  ///< status of the tick's program
  int iterations = 0;                                 ///< iterations of the solver
  double objective = 0.0;                             ///< cost of the plan; infinite: no plan
  double kkt = 0.0;                                   ///< scaled KKT residual
  double violation = 0.0;                             ///< largest violation of the constraints
  double seconds = 0.0;      ///< wall-clock time from the measurement to the input
  double preparation = 0.0;  ///< wall-clock time before the measurement
  double check = 0.0;        ///< wall-clock time after the input, see ControlTick
};

/// Plan of a tick: states and inputs at its nodes.
struct LoopPlan {
  double made_at = 0.0;         ///< time of the tick in seconds
  std::vector<Sample> samples;  ///< nodes of the plan
};

/// A tick whose constraints could not be satisfied, with the problem of the controller, for
/// explain() (saltus/solve/explain.hpp) after the run.
struct UnmetTick {
  double time = 0.0;              ///< time of the tick in seconds
  OptimalControlProblem problem;  ///< from the measured state, with the data of the tick
  ShootingOptions shooting;       ///< its grid and integrator
};

/// Result of a closed-loop run.
struct LoopLog {
  bool completed = false;  ///< the plant reached the end, or `until` ended the run
  /// A sentence that names the largest violation, if any.
  std::string message;
  std::string controller, plant;  ///< names
  double period = 0.0;            ///< control period in seconds
  Recording recording;            ///< motion of the plant, with its actual inputs
  std::vector<LoopTick> ticks;    ///< one per tick
  std::vector<LoopPlan> plans;    ///< plans that were stored
  std::vector<UnmetTick> unmet;   ///< the first ones, see LoopOptions::keep_unmet
  LoopStatistics statistics;      ///< statistics of a receding horizon controller for this run
  /// Hard constraints of the controller's problem that the motion violates by more than their
  /// tolerances, largest first: ends, path constraints and bounds. A receding horizon has no end
  /// constraints to check. A feedback law has no problem, so that its list is empty.
  std::vector<LoopMiss> misses;
  /// False: the run ended before the motion of a shrinking horizon; constraints at its end are not
  /// checked. Runs that `until` ended count as complete.
  bool reached_end = true;

  /// True if the run completed and satisfied all constraints of the controller's problem.
  bool ok() const { return completed && reached_end && misses.empty(); }

  /// Last recorded state. Throws DefinitionError if nothing was recorded.
  const VectorXd& final_state() const;
  /// Number of ticks with this source of the input.
  int count(Provenance provenance) const;

  /// One line per tick: "t [s]", provenance, status, iterations, objective, KKT residual,
  /// violation, solve time, check time, measured states. Computing times differ from run to run.
  std::string ticks_csv() const;
  /// One line per node of every stored plan: "made at [s]", "t [s]", mode, states, inputs.
  std::string plans_csv() const;
  /// Summary of the run: length, misses, provenances, solve times, events, final state.
  std::string summary_json() const;
  /// Writes trajectory.csv, events.csv, ticks.csv, summary.json and, if plans were stored,
  /// plans.csv. Creates the folder. Throws InputError naming the file that cannot be written.
  void write(const std::string& folder) const;
};

}  // namespace saltus
