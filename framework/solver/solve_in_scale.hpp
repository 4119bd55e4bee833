// Solving a program in units in which its numbers are of a usual size.
#pragma once

#include "saltus/solver/program_scale.hpp"
#include "saltus/solver/solver.hpp"

namespace saltus {

struct ScaledResult {
  NlpResult nlp;  ///< of the program as it is: point, cost, residual
  /// The residual in the scale in which it was solved or, where values at the solution turned out
  /// to have other sizes, in theirs.
  KktResidual in_scale;
  /// Whether the point meets the tolerance in the units of the program only.
  bool is_doubtful = false;
};

/// Solves the program as it is stated where what is known of its values at the start has a usual
/// size (cost and rows with derivatives of unusual size are scaled), and divided by its sizes where
/// not. If the solver fails on a program whose sizes, estimated ones too, are far from usual,
/// or values at its solution are not usual and the residual in their scale is large, it is solved
/// once more, divided by its sizes.
ScaledResult solve_in_scale(Solver& solver, NonlinearProgram& program, const NlpPoint& start,
                            bool warm, const Quantities& quantities = {});

}  // namespace saltus
