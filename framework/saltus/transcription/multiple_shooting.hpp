// Transcribes a problem with a grid and an integrator into a sparse nonlinear program, and converts
// results back.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/qp/qp_result.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/grid.hpp"
#include "saltus/transcription/solution.hpp"
#include "saltus/verify/verification.hpp"

namespace saltus {

class ShootingProgram;

/// Options of the transcription.
struct ShootingOptions {
  int intervals_per_phase = 30;     ///< number of intervals of every phase
  std::vector<int> intervals = {};  ///< number per phase; replaces intervals_per_phase
  std::vector<Mesh> meshes = {};    ///< per phase; replaces both numbers of intervals
  IntegratorChoice integrator;      ///< required; see saltus/integrators/
  GridAccuracy accuracy = {};       ///< tolerances of the verification in solve()
  /// Threads that evaluate intervals and terms, for offline problems with a thousand intervals or
  /// more. Results are bitwise identical for any number.
  int threads = 1;
  /// Automatic scaling in solve(). Cost and rows whose derivatives at the start are below 1e-2 or
  /// above 5e3 are multiplied by powers of two. If the program cannot be solved, it is solved again
  /// with values divided by their sizes (solver/solve_in_scale.hpp). False: one attempt, exactly as
  /// stated.
  bool automatic_scale = true;
};

/// Transcription of a problem by direct multiple shooting into a sparse nonlinear program. The
/// constructor fixes patterns and sizes. Start, data, event times and penalty weights may change
/// between solves. After a move, the members of the source throw DefinitionError.
class MultipleShooting : public DataByName<MultipleShooting> {
 public:
  /// Throws DefinitionError if the problem or the options are invalid.
  MultipleShooting(OptimalControlProblem problem, ShootingOptions options);
  ~MultipleShooting();
  MultipleShooting(MultipleShooting&&) noexcept;
  MultipleShooting& operator=(MultipleShooting&&) noexcept;

  /// The nonlinear program for a solver.
  NonlinearProgram& nlp();
  /// The problem with the current schedule and penalty weights.
  const OptimalControlProblem& problem() const;
  /// Data of the next solve.
  const ProblemData& data() const;
  /// The given options with the resulting meshes.
  const ShootingOptions& options() const { return options_; }
  /// The intervals.
  const Grid& grid() const;
  /// The variables.
  const Layout& layout() const;
  /// The nonlinear program with the grid points of its terms, for PlanShift.
  const ShootingProgram& program() const { return checked(); }
  /// The same, for OptimumDerivatives. It commits perturbed data and then restores the current
  /// data.
  ShootingProgram& editable_program() { return checked(); }
  /// Stages of nlp(): one per node of a phase, with the interval that begins there.
  qp::StageStructure stages() const;

  // --- data of the next solve. Names and sizes are checked before any change. Setters
  // allocate only if they throw. ---
  /// Sets the start time (s) and the state.
  void start_at(double t, const VectorRef& state);
  /// Sets the start time only. The grid moves; the state is unchanged.
  void start_time(double t);
  /// Sets the remaining duration of the first phase and the remaining total time, s, for a
  /// shrinking horizon. The sides of `first_phase` are equal if its duration is fixed. Windows in
  /// phase time count from the new start. Throws DefinitionError if a window limit no longer
  /// coincides with a node.
  void set_remaining(Bounds first_phase, Bounds total_time);
  /// Common implementation of set_data() (saltus/ocp/problem.hpp).
  void set_entries(std::string_view name, const VectorRef& values,
                   std::span<const ParameterEntry> entries);
  /// Moves an event of the schedule, s.
  void retime(std::string_view event, double time);
  /// Replaces events, modes and times, within the modes and the capacity declared by the problem's
  /// schedule. Events named by windows must exist.
  void set_schedule(const Schedule& schedule);
  /// Sets the input applied before the horizon, for penalise_change(). Without it, the first
  /// interval is not charged. NaN marks an entry that did not exist and is not charged.
  void set_previous_input(const VectorRef& input);
  /// Changes the weight of a soft term by its name.
  void set_penalty_weight(std::string_view weight_name, double weight);

  /// The initial guess of the problem as a point of the program.
  NlpPoint initial_guess() const;
  /// A guess sampled from another solution of the same problem at the same absolute times, with its
  /// unknown parameters. Free phases keep their end times. After its end, the last state and input
  /// continue. Throws DefinitionError if the trajectory is empty or has sizes of another problem.
  NlpPoint guess_from(const Trajectory& trajectory) const;

  /// The trajectory of a point of the program. Throws DefinitionError if w has the wrong size.
  Trajectory trajectory(const VectorXd& w) const;
  /// Converts a solver's result for nlp() into a solution. Guards that end phases are sampled at
  /// the nodes and at `inside` points in each interval.
  Solution interpret(NlpResult result, int inside = 0);

 private:
  ShootingProgram& checked() const;
  /// Commits an edited copy of the current data.
  template <class Edit>
  void change(Edit&& edit);

  std::unique_ptr<ShootingProgram> program_;
  ProblemData next_;  // buffer for edits, to avoid allocation
  ShootingOptions options_;
};

/// Solves from the problem's initial guess and verifies the plan against the definition of the
/// problem (Solution::verification). Status and message report results beyond
/// ShootingOptions::accuracy.
Solution solve(MultipleShooting& shooting, Solver& solver);
/// Solves from this point with the current data and schedule. Warm-starts if the point has
/// multipliers.
Solution solve(MultipleShooting& shooting, Solver& solver, const NlpPoint& start);

// The next solve of a shooting as a separate problem.

/// The problem with the current data of the shooting, e.g. in a controller: start, times, schedule,
/// parameters. Independent of the shooting. Allocates, so do not call it in a control loop.
OptimalControlProblem current_problem(const MultipleShooting& shooting);
/// Deprecated name.
[[deprecated("use current_problem; removed in 0.4")]] inline OptimalControlProblem present_problem(
    const MultipleShooting& shooting) {
  return current_problem(shooting);
}

}  // namespace saltus
