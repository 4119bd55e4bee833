// Tests a claim that no point near this one meets the rows.
#pragma once

#include <optional>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// A point near w that violates rows and bounds by at most half as much in sum, each row relative
/// to its derivatives: a few steps of the Gauss-Newton method towards the equalities and the
/// violated sides, the shortest ones in variables that are divided by their largest derivative.
/// Units of variables do not matter. Empty if there is none: w may be a minimum of the violation.
std::optional<VectorXd> step_towards_rows(NonlinearProgram& program, const VectorXd& w);

}  // namespace saltus
