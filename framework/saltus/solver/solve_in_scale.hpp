// Solving a program in the user's units first, and in units of its values where that fails. Success
// is judged from the program as it is stated, whatever it was divided by.
#pragma once

#include "saltus/solver/optimum_check.hpp"
#include "saltus/solver/program_scale.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

/// What a solve gave, and how good it is.
struct ScaledResult {
  NlpResult nlp;  ///< of the program as it is: point, cost, residual; effort of all attempts
  /// The residual in the scale in which it was solved.
  KktResidual in_scale;
  /// Of the program as it is stated. Empty gap (infinite) where nothing was solved.
  OptimumCheck check;
  /// Largest |violation| of a row or bound over its size: the largest of 1, its finite sides and
  /// its largest term.
  double violation = infinity;
  /// True if the solver reports success, but the point misses most_gain() or most_violation.
  bool is_doubtful = false;
};

/// What an optimum may still gain, relative to its cost.
double most_gain(const Solver& solver);
/// What an optimum may violate, relative to the size of the row.
inline constexpr double most_violation = 1e-6;

/// Solves the program as it is stated; only cost and rows whose derivatives are below 1e-2 or above
/// 5e3 at the start are multiplied by powers of two. If the solver fails, or its result is no
/// optimum of the program as it is stated, it is solved again with everything divided by its size
/// (ProgramSize::to_one). Returns the first result that is an optimum, or else the best one. Where
/// the cost of that can still fall, it is solved once more with the cost magnified. Where it is
/// `infeasible`, but a step towards the rows helps (step_towards_rows()), the solve begins again
/// from there.
ScaledResult solve_in_scale(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                            bool warm, const Quantities& quantities = {});

/// Solves the program exactly as it is stated, once, and judges the result.
ScaledResult solve_as_stated(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                             bool warm, const Quantities& quantities = {});

/// Judges a result from the program as it is stated: fills in all but `nlp` and `in_scale`.
void judge(const Solver& solver, NonlinearProgram& program, const Quantities& quantities,
           ScaledResult& result);

/// The same for control loops, where nothing is judged but the residual in the scale of the values
/// at the solution: `check` and `violation` stay empty.
ScaledResult solve_tick_in_scale(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                                 bool warm, const Quantities& quantities);

}  // namespace saltus
