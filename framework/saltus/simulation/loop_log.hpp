// Log of a closed-loop run: motion of the plant, ticks of the controller, plans and events.
#pragma once

#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "saltus/model/integrator.hpp"
#include "saltus/mpc/receding_horizon.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/solution.hpp"

namespace saltus {

// Violations of the controller's problem by a closed-loop run: ends, path constraints and bounds,
// evaluated on the motion of the plant in the units of the terms.

/// True if the window is open at time t of a phase that begins at `phase_start`, s.
bool is_in_force(const Window& window, const Schedule& schedule, double phase_start, double t);

/// A violated hard constraint with its largest violation.
struct LoopMiss {
  std::string phase;       ///< name of the phase
  std::string term;        ///< its name; "state 2", "input 0", "duration" or "total time"
  double time = 0.0;       ///< time in seconds of the largest violation
  double amount = 0.0;     ///< beyond the bound, in the unit of the term; infinite: not a number
  double tolerance = 0.0;  ///< in the unit of the term; smaller violations are ignored
  bool at_end = false;     ///< constraint at the start or end of a phase, not along it
};

/// Follows a motion through the phases of a problem and records violations. Formulas that throw
/// count as an infinite violation.
class MissRecord {
 public:
  /// Tolerances per row: `relative` times the largest of 1, the violated bound of the row and its
  /// nominal value. `of_term` overrides the tolerance of named terms; a loop throws DefinitionError
  /// for a name that no phase has and for tolerances that are negative or NaN.
  struct Tolerance {
    double relative = 1e-6;                      ///< relative tolerance
    std::map<std::string, double> of_term = {};  ///< tolerances of named terms, in their units
    /// Tolerance of a row of this term.
    double of(const std::string& term, const Bounds& bounds, double nominal = 1.0) const;
  };

  /// `problem` must outlive the record. `parameters` returns the current p of a phase. With
  /// `recedes` the horizon moves along: no phase ends, and windows count from each instant.
  MissRecord(const OptimalControlProblem& problem, Tolerance tolerance,
             std::function<VectorXd(int phase)> parameters, bool recedes);

  /// Starts the first phase.
  void begin(double t, const VectorXd& state, const VectorXd& input);
  /// Checks bounds and path constraints at an instant with this input.
  void look(double t, const VectorXd& state, const VectorXd& input);
  /// Ends the phase before the event and starts the next one, if any, after it.
  void end_phase(const HybridEvent& event, const VectorXd& input);
  /// True if the last phase has ended.
  bool is_over() const { return is_over_; }

  /// Violations beyond their tolerances, largest ratio first.
  std::vector<LoopMiss> misses() const;

 private:
  const PhaseDefinition& definition() const { return problem_.phases()[phase_]; }
  bool is_in_force(const Window& window, double t) const;
  void judge(const std::string& term, double t, double value, const Bounds& bounds, double nominal,
             bool at_end);
  void judge(const Term& term, double t, const VectorXd& z, bool at_end);
  VectorXd argument(double t, const VectorXd& state, const VectorXd& input) const;
  void judge_once(Term::Domain domain, double t, const VectorXd& state, const VectorXd& input);

  const OptimalControlProblem& problem_;
  Tolerance tolerance_;
  std::function<VectorXd(int)> parameters_;
  bool recedes_;
  int phase_ = 0;
  bool is_over_ = false;
  double begin_ = 0.0, entered_ = 0.0;  // in seconds
  std::vector<LoopMiss> largest_;
};

/// Describes a miss in one clause: "phase 'swing up', 'upright' is missed by 0.33 at t = 1.9 s
/// (tolerance 3e-06)".
std::string describe(const LoopMiss& miss);

// Trajectories as tables: states, inputs, modes and events over time, in the format that the plot
// scripts read.

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
/// The same for a solution. It also writes summary.json and multipliers.csv for `saltus view`.
void save(const OptimalControlProblem& problem, const Solution& plan, const std::string& folder,
          std::vector<std::string> state_names = {}, std::vector<std::string> input_names = {});

/// CSV table of multipliers over time: "t [s]", and one column per row of a constraint. The name of
/// a column contains phase (if there are several), term and row. Times at which a constraint has no
/// grid point have empty cells. Constraints at a single time are left out.
std::string multipliers_csv(const Solution& plan);
/// Text of summary.json: name, status, cost and its terms, multipliers and violations. Multipliers
/// are derivatives of the cost with respect to the lower and the upper bound of a row, summed over
/// the grid points.
std::string summary_json(const std::string& name, const Solution& plan);

/// Result of a closed-loop run.
struct LoopLog {
  /// A tick of the controller: its measurement and its answer.
  struct Tick {
    double time = 0.0;  ///< start of the tick in seconds
    VectorXd measured;  ///< the state with noise and delay
    /// Source of the input; empty for a feedback law, whose following fields are unset too.
    std::optional<Provenance> provenance;
    SolveStatus status = SolveStatus::invalid_problem;  ///< status of the tick's program
    std::string message;                                ///< reason why there is no plan, if known
    int iterations = 0;                                 ///< iterations of the solver
    double objective = 0.0;                             ///< cost of the plan; infinite: no plan
    double kkt = 0.0;                                   ///< scaled KKT residual
    double violation = 0.0;                             ///< largest violation of the constraints
    double seconds = 0.0;      ///< wall-clock time from the measurement to the input
    double preparation = 0.0;  ///< wall-clock time before the measurement
    double check = 0.0;        ///< wall-clock time after the input, see ControlTick
  };

  /// Plan of a tick: states and inputs at its nodes.
  struct Plan {
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

  bool completed = false;  ///< the plant reached the end, or `until` ended the run
  /// A sentence that names the largest violation, if any.
  std::string message;
  std::string controller, plant;  ///< names
  double period = 0.0;            ///< control period in seconds
  Recording recording;            ///< motion of the plant, with its actual inputs
  std::vector<Tick> ticks;        ///< one per tick
  std::vector<Plan> plans;        ///< plans that were stored
  std::vector<UnmetTick> unmet;   ///< the first ones, see LoopOptions::keep_unmet
  LoopStatistics statistics;      ///< statistics of a receding horizon controller for this run
  /// Hard constraints of the controller's problem that a sample of the motion violates by more than
  /// their tolerances, largest first: ends, path constraints and bounds. More samples per tick find
  /// shorter violations. A receding horizon has no end constraints to check. A feedback law has no
  /// problem, so its list is empty.
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
/// Deprecated name.
using LoopTick [[deprecated("use LoopLog::Tick; removed in 0.4")]] = LoopLog::Tick;
/// Deprecated name.
using LoopPlan [[deprecated("use LoopLog::Plan; removed in 0.4")]] = LoopLog::Plan;

}  // namespace saltus
