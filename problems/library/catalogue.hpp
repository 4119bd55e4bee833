// The catalogue of problems with known answers, for tests and benchmarks.
#pragma once

#include <string>
#include <vector>

#include "problems/library/reference_case.hpp"
#include "problems/library/simulation_case.hpp"

namespace saltus {

/// All optimisation problems, in the order of their ids.
const std::vector<ReferenceCase>& reference_cases();
/// All simulations and closed forms, in the order of their ids.
const std::vector<SimulationCase>& simulation_cases();

/// The case with this id or name. Throws InputError that suggests the nearest one.
const ReferenceCase& reference_case(const std::string& id_or_name);

}  // namespace saltus
