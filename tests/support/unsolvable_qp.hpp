// Random programs in stages without a solution, each with its proof: contradicting sides, or a
// direction along which the cost decreases without bound.
#pragma once

#include <cstdint>
#include <string>

#include "tests/support/random_qp.hpp"

namespace saltus::testing {

/// Infeasible by construction. `proof` describes the contradiction, and `gap` is its size.
struct InfeasibleQp {
  qp::StageQp qp;
  std::string proof;
  double gap = 0.0;
};
InfeasibleQp infeasible_qp(std::uint64_t seed, const RandomQpOptions& options = {});

/// Feasible, and unbounded along a given direction.
struct UnboundedQp {
  qp::StageQp qp;
  qp::StagePoint feasible, direction;  ///< feasible + s direction is feasible for all s >= 0
  double slope = 0.0;                  ///< slope of the cost along it, negative
  std::string proof;
};
UnboundedQp unbounded_qp(std::uint64_t seed, const RandomQpOptions& options = {});

}  // namespace saltus::testing
