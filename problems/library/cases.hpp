// The optimisation problems of the library, a function and a file each, in the order of their ids.
#pragma once

#include "problems/library/reference_case.hpp"

namespace saltus::library {

// --- A: switched and hybrid systems
// ---------------------------------------------------------------

// --- B: several phases
// ----------------------------------------------------------------------------
ReferenceCase bryson_denham();      // B01
ReferenceCase brachistochrone();    // B03
ReferenceCase particle_steering();  // B11
ReferenceCase maximum_range();      // B15
ReferenceCase interior_point();     // B22
ReferenceCase van_der_pol();        // B25

// --- C: model predictive control
// ------------------------------------------------------------------
ReferenceCase phase_transition();  // C02
ReferenceCase pendulum_on_cart();  // C03

}  // namespace saltus::library
