#include "saltus/simulation/plants.hpp"

#include <fmt/format.h>

#include "saltus/core/error.hpp"

namespace saltus {

void LoopPlant::disturb(const VectorRef&) {
  throw DefinitionError("closed loop: the state of " + name() + " cannot be disturbed.");
}

std::string describe_bad_length(double length) {
  return fmt::format("the time step is {} s, expected 0 or more", length);
}

}  // namespace saltus
