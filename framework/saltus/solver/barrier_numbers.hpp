// Numbers that several parts of the barrier method use.
#pragma once

#include <limits>

#include "saltus/core/types.hpp"

namespace saltus::barrier {

inline constexpr double epsilon = std::numeric_limits<double>::epsilon();
inline constexpr double largest_estimate = 1e3;  ///< of multipliers that begin anew
inline constexpr double least_fraction = 0.99;   ///< of the way to a side that a step may go

/// Multipliers of rows whose slopes are 100 at most that need an explanation.
inline constexpr double excessive_multiplier = 1e4;
/// Fraction of its distance to a side that an iterate keeps when the side moves towards it.
inline constexpr double kept_room = 0.1;

inline double largest(const VectorXd& v) { return v.size() == 0 ? 0.0 : v.cwiseAbs().maxCoeff(); }

}  // namespace saltus::barrier
