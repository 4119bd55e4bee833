// A primal-dual point: the result of a solver and the input of a warm start.
#pragma once

#include "saltus/core/types.hpp"

namespace saltus {

/// Point of a program in variables w with rows J w (or g(w)). The Lagrangian is cost + lambda' rows
/// + z' w.
struct PrimalDualPoint {
  VectorXd w;       ///< variables
  VectorXd lambda;  ///< row multipliers, positive at an active upper side
  VectorXd z;       ///< bound multipliers, positive at the upper bound, negative at the lower
};

}  // namespace saltus
