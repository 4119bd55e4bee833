// Numbers that several parts of the barrier method use.
#pragma once

#include <limits>

#include "saltus/core/types.hpp"

namespace saltus::barrier {

inline constexpr double epsilon = std::numeric_limits<double>::epsilon();
inline constexpr double largest_estimate = 1e3;  ///< of multipliers that begin anew
inline constexpr double least_fraction = 0.99;   ///< of the way to a side that a step may go

inline double largest(const VectorXd& v) { return v.size() == 0 ? 0.0 : v.cwiseAbs().maxCoeff(); }

}  // namespace saltus::barrier
