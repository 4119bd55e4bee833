// Forces of the pushes of the settings.
#pragma once

#include <vector>

#include "saltus/robots/walking/biped_settings.hpp"

namespace saltus::robots::walking {

/// The first push, those of the list and the random ones, sorted by time. With random pushes, the
/// first push is only their pattern and is left out. Throws InputError for a list that cannot be
/// read, for pushes that overlap, and for random pushes that do not fit into the time.
std::vector<Push> all_pushes(const Push& first, const MorePushes& more);

}  // namespace saltus::robots::walking
