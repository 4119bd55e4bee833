// What a function was before eliminate(): for integrators that take the algebraic states as
// unknowns of their own.
#pragma once

#include "saltus/model/algebraic.hpp"

namespace saltus {

/// The function of (t | x z | u | p) and the equations of which eliminate() made `function`; empty
/// for any other.
AlgebraicPart part_before_elimination(const Function& function);

}  // namespace saltus
