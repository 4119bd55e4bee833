// A primal-dual point of a program: what solvers return and what warm starts hand on.
#pragma once

#include "saltus/core/types.hpp"

namespace saltus {

/// Of a program in variables w with rows J w (or g(w)). Lagrangian: cost + lambda' rows + z' w.
struct PrimalDualPoint {
  VectorXd w;       ///< variables
  VectorXd lambda;  ///< row multipliers, positive where the upper side holds the cost up
  VectorXd z;       ///< bound multipliers, positive at the upper bound, negative at the lower
};

}  // namespace saltus
