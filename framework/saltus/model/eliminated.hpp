// Recovers the DAE behind an eliminated function, for integrators that treat the algebraic states
// as unknowns.
#pragma once

#include "saltus/model/algebraic.hpp"

namespace saltus {

/// The function of (t | x z | u | p) and the equations from which eliminate() made `function`.
/// Empty for any other function.
AlgebraicPart part_before_elimination(const Function& function);

}  // namespace saltus
