// The simulations of the library, a function and a file each, in the order of their ids.
#pragma once

#include "problems/library/simulation_case.hpp"

namespace saltus::library {

SimulationCase capture_point();          // C07
SimulationCase van_der_pol_stiff();      // D01
SimulationCase robertson_kinetics();     // D02
SimulationCase restricted_three_body();  // D06
SimulationCase matrix_exponential();     // D12

}  // namespace saltus::library
