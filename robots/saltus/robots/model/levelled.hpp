// A sole that tilts, as planners see it.
#pragma once

#include <cmath>

#include "saltus/robots/model/foot.hpp"

namespace saltus {

/// The same place and heading, flat on level ground.
inline SoleFrame levelled(const SoleFrame& sole) {
  return flat_sole(sole.position, std::atan2(sole.rotation(1, 0), sole.rotation(0, 0)));
}

}  // namespace saltus
