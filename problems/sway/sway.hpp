// A biped on both feet that sways from side to side: a second problem on the same layer as push
// recovery, without any of its code.
#pragma once

#include "problems/biped/configurable_biped.hpp"
#include "saltus/app/program.hpp"

namespace saltus::sway {

/// Creates the problem. It counts as recovered if the CoM stays within 1 cm of its reference after
/// the first cycle.
std::unique_ptr<walking::ConfigurableBiped> make_sway();

/// Entry for `saltus run sway`.
ProblemEntry entry();

}  // namespace saltus::sway
