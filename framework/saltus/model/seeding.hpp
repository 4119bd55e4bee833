// How few evaluations give all entries of a sparse Jacobian or Hessian: which inputs share a
// direction of differentiation.
//
// Columns of a Jacobian that have no row in common can be differentiated in one direction, because
// every entry of the sum of the columns still belongs to one of them. A lane of a dual number is
// one such direction, a pass is one evaluation with all lanes (Curtis, Powell and Reid 1974). A
// Hessian entry (i, j) is found with outer direction j and lane i or the other way round, so the
// outer directions need only touch every pair once: a small vertex cover of the pairs.
#pragma once

#include <vector>

#include "saltus/core/sparsity.hpp"

namespace saltus {

/// d z[input] / d lane = 1.
struct Seed {
  int input;  ///< of z
  int lane;   ///< the direction
};
/// entries[entry] is the factor of `lane` in output `row` (Hessian: in the weighted sum, row 0).
struct Reading {
  int row;    ///< output
  int lane;   ///< direction
  int entry;  ///< in the order of the pattern
};

/// One sweep for entries of a Jacobian.
struct JacobianPass {
  std::vector<Seed> seeds;        ///< what moves along which lane
  std::vector<Reading> readings;  ///< what stands where afterwards
  std::vector<double> tangents;   ///< the seeds as numbers, `lanes` per input
};
/// Passes of at most `lanes` directions for a Jacobian; inputs that do not occur are not seeded.
std::vector<JacobianPass> jacobian_passes(const SparsityPattern& jacobian, int lanes);

/// One sweep for entries of a Hessian.
struct HessianPass {
  std::vector<int> outer;              ///< inputs that form the one outer direction
  std::vector<Seed> seeds;             ///< what moves along which lane
  std::vector<Reading> readings;       ///< what stands where afterwards
  std::vector<double> tangents;        ///< the seeds as numbers, `lanes` per input
  std::vector<double> outer_tangents;  ///< the outer direction, one number per input
};
/// Passes of one outer and at most `lanes` inner directions, for a lower-triangular pattern.
std::vector<HessianPass> hessian_passes(const SparsityPattern& hessian, int lanes);

}  // namespace saltus
