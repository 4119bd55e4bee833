// Tolerances of the verifier in the user's units: the accuracy that a plan needs to be a solution.
#pragma once

namespace saltus {

/// Required accuracy of a plan. If it is exceeded, the status of the solution is coarse_grid or
/// numerical_failure, or only the message changes where a member says so.
struct GridAccuracy {
  /// False: solve() does not verify, and Solution::verification stays empty.
  bool verify = true;
  /// Tolerance of a bound of a row: this value times the largest of 1, the magnitude of the bound
  /// and the declared nominal magnitude. Phase::allow() overrides it for a term.
  double rows = 1e-6;
  /// Tolerance between the nodes, as a multiple of that at the nodes. Phase::allow() overrides it
  /// for a term.
  double between_nodes = 1.0;
  /// Defect of one interval, relative to max(unit of the state, |state|) (VerifiedDefect).
  double defect = 1e-4;
  /// Sum of the defects along a phase, relative. Exceeding it changes only the message.
  double integration = 1e-3;
  /// Difference of the cost, relative to the larger of |cost| and the sum of the magnitudes of its
  /// terms. A difference below 1e-6 is always allowed.
  double cost = 1e-4;
  /// Deviation of the open loop from the plan at the end of a phase, relative. Exceeding it changes
  /// only the message.
  double open_loop = 1e-3;
  /// Largest earlier crossing of zero by the guard that ends a phase, relative to its largest
  /// value.
  double crossing = 1e-2;
};

}  // namespace saltus
