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

/// Solves the program as stated; only cost and rows with derivatives below 1e-2 or above 5e3 at the
/// start are multiplied by powers of two. If the solver gives up, solves again with everything
/// divided by its size (ProgramSize::to_one). If the result is no optimum of the program as stated,
/// or its values show that the program was badly scaled, continues from it in scale, and solves
/// again from the start in the scale of the start, which does not depend on units. Of several
/// optima, returns the cheapest one; if none was found, the best result. If its cost can still
/// decrease, solves up to three more times with the cost magnified. After a breakdown at a point
/// that satisfies the rows, solves again from there in the scale of that point if it differs. A
/// failure at a point that violates the rows is `infeasible` if is_proved_infeasible(). Otherwise,
/// if step_towards_rows() reduces the violation, solves again from there.
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
