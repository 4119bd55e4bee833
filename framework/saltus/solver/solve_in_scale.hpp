// Solves a program in the user's units first, and in scaled units if that fails. Success is judged
// for the program as stated, regardless of the scaling.
#pragma once

#include "saltus/solver/optimum_check.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

/// Result of a solve and its quality.
struct ScaledResult {
  NlpResult nlp;  ///< result for the program as stated; effort of all attempts
  /// Residual in the scale of the solve.
  KktCheck::Residual in_scale;
  /// Check of the program as stated. The gap is infinite if nothing was solved.
  OptimumCheck check;
  /// Largest violation of a row or bound relative to its size: the largest of 1, its finite sides
  /// and its largest term.
  double violation = infinity;
  /// True if the solver reports success, but the point exceeds most_gain() or most_violation.
  bool is_doubtful = false;
};

/// Largest possible cost decrease of an accepted optimum, relative to its cost.
double most_gain(const Solver& solver);
/// Largest violation of an accepted optimum, relative to the size of the row.
inline constexpr double most_violation = 1e-6;

/// Solves the program as stated, except that cost and rows with derivatives below 1e-2 or above 5e3
/// at the start are multiplied by powers of two. Of several optima, returns the cheapest one; if
/// none was found, the best result. Further solves follow in these cases:
/// - The solver gives up. The next solve divides everything by its size (ProgramSize::to_one).
/// - The result is not an optimum of the program as stated, or its values show that the program was
///   badly scaled. One solve continues from it in scale. Another one begins at the start in the
///   scale of the start, which does not depend on units.
/// - The cost can still decrease. Up to three more solves use a magnified cost.
/// - The solver breaks down at a point that satisfies the rows. The next solve begins there in the
///   scale of that point if it differs.
/// - The solver fails at a point that violates the rows. The status is `infeasible` if
///   is_proved_infeasible(). Otherwise, if step_towards_rows() reduces the violation, the next
///   solve begins there.
ScaledResult solve_in_scale(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                            bool warm, const Quantities& quantities = {});

/// Solves the program exactly as stated, once, and judges the result.
ScaledResult solve_as_stated(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                             bool warm, const Quantities& quantities = {});

/// Judges a result for the program as stated: sets all fields except `nlp` and `in_scale`.
void judge(const Solver& solver, NonlinearProgram& program, const Quantities& quantities,
           ScaledResult& result);

/// The same for control loops. It judges only the residual, in the scale of the values at the
/// solution; `check` and `violation` stay empty.
ScaledResult solve_scaled_tick(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                               bool warm, const Quantities& quantities);

}  // namespace saltus
