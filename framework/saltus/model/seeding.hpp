// Compression of sparse Jacobians and Hessians: inputs that can share a direction of
// differentiation, so that few evaluations give all entries.
//
// Columns of a Jacobian without a common row can share one direction: every entry of their sum
// belongs to one column. A lane of a dual number is one direction, and a pass is one evaluation
// with all lanes (Curtis, Powell and Reid 1974). A Hessian entry (i, j) follows from outer
// direction j and lane i, or vice versa. The outer directions therefore need to touch every pair
// only once: they form a small vertex cover of the pairs.
#pragma once

#include <vector>

#include "saltus/core/sparsity.hpp"

namespace saltus {

/// Seeds d z[input] / d lane = 1.
struct Seed {
  int input;  ///< index in z
  int lane;   ///< direction
};
/// entries[entry] is the factor of `lane` in output `row`. For a Hessian, row 0 is the weighted
/// sum.
struct Reading {
  int row;    ///< output
  int lane;   ///< direction
  int entry;  ///< index in the order of the pattern
};

/// One evaluation for entries of a Jacobian.
struct JacobianPass {
  std::vector<Seed> seeds;        ///< inputs seeded per lane
  std::vector<Reading> readings;  ///< entries read after the evaluation
  std::vector<double> tangents;   ///< the seeds as numbers, `lanes` per input
};
/// Passes of at most `lanes` directions for a Jacobian. Inputs without entries are not seeded.
std::vector<JacobianPass> jacobian_passes(const SparsityPattern& jacobian, int lanes);

/// One evaluation for entries of a Hessian.
struct HessianPass {
  std::vector<int> outer;              ///< inputs of the outer direction
  std::vector<Seed> seeds;             ///< inputs seeded per lane
  std::vector<Reading> readings;       ///< entries read after the evaluation
  std::vector<double> tangents;        ///< the seeds as numbers, `lanes` per input
  std::vector<double> outer_tangents;  ///< the outer direction, one number per input
};
/// Passes of one outer and at most `lanes` inner directions for a lower-triangular pattern.
std::vector<HessianPass> hessian_passes(const SparsityPattern& hessian, int lanes);

}  // namespace saltus
