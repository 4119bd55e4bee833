// From a problem, a grid and an integrator to a sparse nonlinear program, and back to a solution.
#pragma once

#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "saltus/ocp/data_by_name.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/qp/stage_structure.hpp"
#include "saltus/solver/solver.hpp"
#include "saltus/transcription/grid.hpp"
#include "saltus/transcription/layout.hpp"
#include "saltus/transcription/problem_data.hpp"
#include "saltus/transcription/solution.hpp"
#include "saltus/verify/accuracy.hpp"

namespace saltus {

class ShootingProgram;

/// How a problem is transcribed.
struct ShootingOptions {
  int intervals_per_phase = 30;     ///< of every phase
  std::vector<int> intervals = {};  ///< per phase, in place of the number above
  std::vector<Mesh> meshes = {};    ///< per phase, in place of both
  IntegratorChoice integrator;      ///< required; see saltus/integrators/
  GridAccuracy accuracy = {};       ///< tolerances of the verification by solve()
  /// That evaluate intervals and terms, for offline problems of a thousand intervals and more. What
  /// comes out is the same to the bit, whatever their number.
  int threads = 1;
  /// For solve(): cost and rows whose derivatives at the start are below 1e-2 or above 5e3 are
  /// multiplied by powers of two, and a program that cannot be solved so is solved again divided by
  /// the sizes of its values (solver/solve_in_scale.hpp). Off: one attempt, exactly as stated.
  bool automatic_scale = true;
};

/// Direct multiple shooting. Patterns and sizes are fixed by the constructor; start, data, event
/// times and penalty weights may change between solves. One that was moved from has no program: its
/// members throw DefinitionError.
class MultipleShooting : public DataByName<MultipleShooting> {
 public:
  /// Throws DefinitionError when the problem or the options are wrong.
  MultipleShooting(OptimalControlProblem problem, ShootingOptions options);
  ~MultipleShooting();
  MultipleShooting(MultipleShooting&&) noexcept;
  MultipleShooting& operator=(MultipleShooting&&) noexcept;

  /// The program, for a solver.
  NonlinearProgram& nlp();
  /// As defined, with the present schedule and penalty weights.
  const OptimalControlProblem& problem() const;
  /// Of the next solve.
  const ProblemData& data() const;
  /// As given, with the meshes that follow from them.
  const ShootingOptions& options() const { return options_; }
  /// Its intervals.
  const Grid& grid() const;
  /// Its variables.
  const Layout& layout() const;
  /// What nlp() is, with the grid points of its terms: for PlanShift.
  const ShootingProgram& program() const { return checked(); }
  /// The same, for OptimumDerivatives, which commits data beside the present ones and these again.
  ShootingProgram& editable_program() { return checked(); }
  /// Stages of nlp(): a node of a phase each, with the interval that begins there.
  StageStructure stages() const;

  // --- data of the next solve; names and sizes are checked before anything changes, and as long as
  // --- nothing is wrong nothing allocates
  // ---------------------------------------------------------
  /// The start of the next solve, s and state.
  void start_at(double t, const VectorRef& state);
  /// Only the time: the grid moves, the state stays to be given.
  void start_time(double t);
  /// What is left of the first phase, s (equal sides where its duration is fixed), and of all of
  /// them: for a horizon that shrinks. Windows in phase time count from the new start;
  /// DefinitionError where a limit of one has no node any more.
  void set_remaining(Bounds first_phase, Bounds total_time);
  /// set_data() in its forms (saltus/ocp/data_by_name.hpp) comes here.
  void set_entries(std::string_view name, const VectorRef& values,
                   std::span<const ParameterEntry> entries);
  /// Moves an event of the schedule, s.
  void retime(std::string_view event, double time);
  /// Other events, modes and times, within the modes and the capacity that the problem's schedule
  /// declares. Events that windows name must be there.
  void set_schedule(const Schedule& schedule);
  /// The input applied before the horizon, for penalise_change(); until given, the first interval
  /// is not charged. NaN marks an entry that did not exist then: it is not charged either.
  void set_previous_input(const VectorRef& input);
  /// Changes the weight of a soft term by its name.
  void set_penalty_weight(std::string_view weight_name, double weight);

  /// The guesses of the problem as a point of the program.
  NlpPoint initial_guess() const;
  /// A guess sampled from another solution of the same problem at the same absolute times, with its
  /// unknown parameters; free phases end when they ended there. Beyond its end the last state and
  /// input go on.
  NlpPoint guess_from(const Trajectory& trajectory) const;

  /// Of a point of the program. Throws DefinitionError if w has another size.
  Trajectory trajectory(const VectorXd& w) const;
  /// Interprets a result of a solver of nlp(). Guards that end phases are looked at where nodes
  /// are, and at so many points inside each interval.
  Solution interpret(NlpResult result, int inside = 0);

 private:
  ShootingProgram& checked() const;
  /// Commits an edited copy of the present data.
  template <class Edit>
  void change(Edit&& edit);

  std::unique_ptr<ShootingProgram> program_;
  ProblemData next_;  // where data are edited, so that nothing allocates
  ShootingOptions options_;
};

/// Solves from the problem's own guess, or from `start` (warm if it has multipliers), and verifies
/// the plan against the definition of the problem (Solution::verification). Status and message say
/// where it exceeds ShootingOptions::accuracy.
Solution solve(MultipleShooting& shooting, Solver& solver);
/// Solves from this point; what data and schedule say now is in force.
Solution solve(MultipleShooting& shooting, Solver& solver, const NlpPoint& start);

}  // namespace saltus
