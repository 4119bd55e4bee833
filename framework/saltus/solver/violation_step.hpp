// Tests a claim that no nearby point satisfies the rows.
#pragma once

#include <optional>

#include "saltus/solver/nonlinear_program.hpp"

namespace saltus {

/// Returns a point within the bounds with at most half the total violation of w, each row relative
/// to its derivatives. It takes a few shortest Gauss-Newton steps towards the equalities and
/// violated sides. Variables are divided by their largest derivative, so that their units do not
/// matter. Empty if the steps do not help: w may be a minimum of the violation.
std::optional<VectorXd> step_towards_rows(NonlinearProgram& program, const VectorXd& w);

}  // namespace saltus
