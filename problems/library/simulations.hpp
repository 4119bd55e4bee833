// The simulations of the library, one function and one file each, in the order of their ids.
#pragma once

#include "problems/library/simulation_case.hpp"

namespace saltus::library {

SimulationCase switched_oscillator();       // A18
SimulationCase filippov_cases();            // A19
SimulationCase capture_point();             // C07
SimulationCase van_der_pol_stiff();         // D01
SimulationCase robertson_kinetics();        // D02
SimulationCase restricted_three_body();     // D06
SimulationCase bouncing_ball_simulation();  // D07
SimulationCase saltation_matrix();          // D09
SimulationCase spring_leg_stance();         // D11
SimulationCase matrix_exponential();        // D12

}  // namespace saltus::library
