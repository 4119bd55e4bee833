// Constants shared by several parts of the barrier method.
#pragma once

#include <limits>

#include "saltus/core/types.hpp"

namespace saltus::barrier {

inline constexpr double epsilon = std::numeric_limits<double>::epsilon();
inline constexpr double largest_estimate = 1e3;  ///< largest estimate of multipliers at a restart
inline constexpr double least_fraction = 0.99;  ///< least fraction of the way to a side that a step
                                                ///< may use

/// Multipliers above this need an explanation if the slopes of the rows are at most 100.
inline constexpr double excessive_multiplier = 1e4;
/// Fraction of its distance to a side that an iterate keeps if the side moves towards it.
inline constexpr double kept_room = 0.1;

inline double largest(const VectorXd& v) { return v.size() == 0 ? 0.0 : v.cwiseAbs().maxCoeff(); }

}  // namespace saltus::barrier
