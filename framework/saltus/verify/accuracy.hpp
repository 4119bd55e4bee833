// What a plan must keep to be called a solution: tolerances of the verifier, in the user's units.
#pragma once

namespace saltus {

/// Accuracy asked of a plan. Beyond it the status of a solution is coarse_grid or
/// numerical_failure, unless a member says that only the message tells.
struct GridAccuracy {
  /// False: solve() does not verify, and Solution::verification stays empty.
  bool verify = true;
  /// Tolerance of a bound of a row: this times the largest of 1, the magnitude of the bound and the
  /// declared nominal magnitude. Phase::allow() sets it for a term.
  double rows = 1e-6;
  /// Tolerance between the nodes, as a multiple of that at nodes. Phase::allow() sets it for a
  /// term.
  double between_nodes = 1.0;
  /// Defect of one interval, relative to max(unit of the state, |state|) (VerifiedDefect).
  double defect = 1e-4;
  /// Sum of the defects along a phase, relative; beyond it only the message tells.
  double integration = 1e-3;
  /// Difference of the cost, relative to the largest of |cost| and what the terms add up to in
  /// magnitude. A difference below 1e-6 is always allowed.
  double cost = 1e-4;
  /// Deviation of the open loop from the plan at the end of a phase, relative; beyond it only the
  /// message tells.
  double open_loop = 1e-3;
  /// How far the guard that ends a phase may have been beyond zero before, relative to its largest
  /// value.
  double crossing = 1e-2;
};

}  // namespace saltus
