// What a closed loop did: the motion of the plant, every tick of the controller, plans and events.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/simulation/loop_misses.hpp"
#include "saltus/simulation/recording.hpp"

namespace saltus {

/// A tick as the controller saw and answered it.
struct LoopTick {
  double time = 0.0;  ///< s
  VectorXd measured;  ///< the state with noise and delay
  /// Where the input came from; a feedback law has no provenance, and nothing of what follows.
  std::optional<Provenance> provenance;
  SolveStatus status = SolveStatus::invalid_problem;  ///< of the tick's program
  int iterations = 0;                                 ///< of the solver
  double objective = 0.0;                             ///< cost of the plan; infinite: there is none
  double kkt = 0.0;                                   ///< residual of the optimality conditions
  double violation = 0.0;                             ///< largest of the constraints
  double seconds = 0.0;      ///< wall clock of the controller, from the measurement to the input
  double preparation = 0.0;  ///< wall clock ahead of the measurement
  double check = 0.0;        ///< wall clock behind the input, see ControlTick
};

/// What the controller had in mind at a tick: states and inputs at the nodes of its plan.
struct LoopPlan {
  double made_at = 0.0;         ///< s
  std::vector<Sample> samples;  ///< of the plan, thin
};

/// A tick whose constraints could not be met, with the problem as the controller had it: for
/// explain() (saltus/solve/explain.hpp), when the run is over.
struct UnmetTick {
  double time = 0.0;              ///< s
  OptimalControlProblem problem;  ///< from the measured state, with the data of the tick
  ShootingOptions shooting;       ///< its grid and its integrator
};

/// Everything that a closed loop leaves.
struct LoopLog {
  bool completed = false;  ///< the plant reached the end, or `until` said that it is over
  /// A sentence; it names the worst miss, if there is any.
  std::string message;
  std::string controller, plant;  ///< their names
  double period = 0.0;            ///< s
  Recording recording;            ///< of the plant, with the inputs that reached it
  std::vector<LoopTick> ticks;    ///< one per tick
  std::vector<LoopPlan> plans;    ///< those that were kept
  std::vector<UnmetTick> unmet;   ///< the first ones, see LoopOptions::keep_unmet
  LoopStatistics statistics;      ///< of a receding horizon controller, in this run
  /// Hard constraints of the controller's problem that the motion misses by more than their
  /// tolerances, the worst first: ends, path constraints and bounds. A receding horizon has no ends
  /// that are reached; a feedback law has no problem, and nothing is missed.
  std::vector<LoopMiss> misses;
  /// False: the run was over before the motion of a shrinking horizon was, whose later ends are not
  /// judged. Runs that `until` ended are as long as they were meant to be.
  bool reached_end = true;

  /// Whether the plant went through the run and missed nothing that the controller's problem asks.
  bool ok() const { return completed && reached_end && misses.empty(); }

  /// Where it ended. Throws DefinitionError if nothing was recorded.
  const VectorXd& final_state() const;
  /// How many ticks got their input from there.
  int count(Provenance provenance) const;

  /// One line per tick: "t [s]", provenance, status, iterations, objective, KKT residual,
  /// violation, solve time, check time, measured states. Times of computing differ from run to run.
  std::string ticks_csv() const;
  /// One line per node of every plan that was kept: "made at [s]", "t [s]", mode, states, inputs.
  std::string plans_csv() const;
  /// The run in figures: length, misses, provenances, solve times, events, final state.
  std::string summary_json() const;
  /// trajectory.csv, events.csv, ticks.csv, summary.json and, if any were kept, plans.csv. Creates
  /// the folder. Throws InputError naming the file that cannot be written.
  void write(const std::filesystem::path& folder) const;
};

}  // namespace saltus
