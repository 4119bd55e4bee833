// Makes GoogleTest print the id of a case instead of its bytes.
#pragma once

#include <ostream>

#include "problems/library/reference_case.hpp"
#include "problems/library/simulation_case.hpp"

namespace saltus {

inline void PrintTo(const ReferenceCase& c, std::ostream* out) { *out << c.id; }
inline void PrintTo(const SimulationCase& c, std::ostream* out) { *out << c.id; }

}  // namespace saltus
