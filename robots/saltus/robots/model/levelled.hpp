// Projection of a tilted sole to level ground, as planners use it.
#pragma once

#include <cmath>

#include "saltus/robots/model/foot.hpp"

namespace saltus::robots {

/// The sole frame at the same position with the same heading, flat on level ground.
inline SoleFrame levelled(const SoleFrame& sole) {
  return flat_sole(sole.position, std::atan2(sole.rotation(1, 0), sole.rotation(0, 0)));
}

}  // namespace saltus::robots
