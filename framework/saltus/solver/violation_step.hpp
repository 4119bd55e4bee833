// Tests a claim that no point near this one meets the rows.
#pragma once

#include <optional>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// A point within the bounds that violates the rows by at most half as much as w in sum, each row
/// relative to its derivatives. Takes a few Gauss-Newton steps towards the equalities and the
/// violated sides, the shortest ones in variables that are divided by their largest derivative, so
/// that units of variables do not matter. Empty if these steps do not help: w may be a minimum of
/// the violation.
std::optional<VectorXd> step_towards_rows(NonlinearProgram& program, const VectorXd& w);

}  // namespace saltus
