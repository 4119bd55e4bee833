// A biped stands on both feet and sways from side to side: a second problem on the same layer as
// push recovery, and no line of it.
#pragma once

#include "problems/biped/configurable_biped.hpp"
#include "saltus/app/program.hpp"

namespace saltus::sway {

/// "Recovered": after the first cycle the CoM stays within 1 cm of where it should be.
std::unique_ptr<walking::ConfigurableBiped> make_sway();

/// `saltus run sway`.
ProblemEntry entry();

}  // namespace saltus::sway
