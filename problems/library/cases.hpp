// The optimisation problems of the library, one function and one file each, in the order of their
// ids.
#pragma once

#include "problems/library/reference_case.hpp"

namespace saltus::library {

// --- A: switched and hybrid systems
// ---------------------------------------------------------------
ReferenceCase three_modes();              // A01
ReferenceCase linear_quadratic_switch();  // A02
ReferenceCase switched_autonomous();      // A04
ReferenceCase fishing();                  // A06
ReferenceCase fishing_relaxed();          // A08
ReferenceCase f8_aircraft();              // A09
ReferenceCase double_tank();              // A11
ReferenceCase tank_on_ramp();             // A12, relaxed
ReferenceCase tank_sequence();            // A12, 16 modes
ReferenceCase calcium_oscillation();      // A13
ReferenceCase turbo_car();                // A14
ReferenceCase switch_of_speed();          // A17
ReferenceCase juggled_ball();             // A20

// --- B: several phases
// ----------------------------------------------------------------------------
ReferenceCase bryson_denham();       // B01
ReferenceCase low_ceiling();         // B02, l = 1/12
ReferenceCase touched_ceiling();     // B02, l = 1/5
ReferenceCase low_ceiling_arcs();    // B02, l = 1/12 in three arcs
ReferenceCase brachistochrone();     // B03
ReferenceCase bang_bang();           // B05
ReferenceCase goddard_rocket();      // B07
ReferenceCase delta_iii();           // B09
ReferenceCase catalyst_mixing();     // B10
ReferenceCase particle_steering();   // B11
ReferenceCase hang_glider();         // B12
ReferenceCase hanging_chain();       // B14, 40 intervals
ReferenceCase hanging_chain_fine();  // B14, 160 intervals
ReferenceCase maximum_range();       // B15
ReferenceCase hyper_sensitive();     // B16
ReferenceCase moon_lander();         // B18
ReferenceCase alp_rider();           // B20
ReferenceCase two_phase_tracking();  // B21
ReferenceCase interior_point();      // B22
ReferenceCase van_der_pol();         // B25

// --- C: model predictive control
// ------------------------------------------------------------------
ReferenceCase phase_transition();       // C02
ReferenceCase pendulum_on_cart();       // C03
ReferenceCase step_recovery_landing();  // C09, first instance
ReferenceCase step_recovery_waiting();  // C09, second instance

// --- E: terms, each with a closed form
// ------------------------------------------------------------------
ReferenceCase dido();             // E01, an integral constraint
ReferenceCase linked_phases();    // E02, links
ReferenceCase tide();             // E03, a free start time
ReferenceCase delayed_product();  // E04, delays
ReferenceCase thermostat_size();  // E05, hysteresis
ReferenceCase soft_targets();     // E06, soft terms
ReferenceCase boundary_layers();  // E07, a graded mesh

}  // namespace saltus::library
