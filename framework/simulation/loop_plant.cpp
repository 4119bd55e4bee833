#include "saltus/simulation/loop_plant.hpp"

#include "saltus/core/error.hpp"

namespace saltus {

void LoopPlant::disturb(const VectorRef&) {
  throw DefinitionError("closed loop: the state of " + name() + " cannot be disturbed.");
}

}  // namespace saltus
