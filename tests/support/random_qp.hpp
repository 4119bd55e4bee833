// Random programs in stages with known optima.
#pragma once

#include <cstdint>
#include <string>

#include "saltus/core/random.hpp"
#include "saltus/qp/stage_qp.hpp"

namespace saltus::testing {

/// Numbers such as free_start are probabilities for each program.
struct RandomQpOptions {
  int min_intervals = 1, max_intervals = 10;
  int max_states = 8, max_inputs = 4;  ///< drawn per stage with `varying_sizes`
  double varying_sizes = 0.5;
  double free_start = 0.2;
  double equality_rows = 0.5;
  double soft_rows = 0.4;
  double semidefinite = 0.2;    ///< Hessians of low rank in the states; inputs always have a cost
  double degenerate = 0.15;     ///< active sides with zero multiplier, and duplicated active rows
  double rank_deficient = 0.1;  ///< dependent equality rows, within a stage and across two
  double tight = 0.1;           ///< sides as close to one another as the margin permits
  double large_multipliers = 0.05;
  double smallest_margin = 1e-6;     ///< margin by which some point satisfies every hard inequality
  double largest_multiplier = 1e6;   ///< in programs with large ones
  double ordinary_multiplier = 1e1;  ///< in other programs
};

struct RandomQp {
  qp::StageQp qp;
  qp::StagePoint optimum;  ///< satisfies the KKT conditions to rounding
  double cost = 0.0;       ///< there
  double margin = infinity;
  bool degenerate = false, rank_deficient = false, semidefinite = false, tight = false;
  bool large_multipliers = false;
  std::string describe() const;
};
RandomQp random_qp(std::uint64_t seed, const RandomQpOptions& options = {});

/// Scale for the residuals of a point: its largest multiplier, at least 1.
double multiplier_scale(const qp::StagePoint& point);

}  // namespace saltus::testing
