// Results of the verifier for a plan: the numbers behind Solution::ok(), in the user's units.
#pragma once

#include <string>
#include <vector>

namespace saltus {

// Tolerances of the verifier in the user's units: the accuracy that a plan needs to be a solution.

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
  /// Defect of one interval, relative to max(unit of the state, |state|) (Verification::Defect).
  double defect = 1e-4;
  /// Sum of the defects along the plan, relative. Exceeding it alone changes only the message; see
  /// open_loop.
  double integration = 1e-3;
  /// Difference of the cost, relative to the larger of |cost| and the sum of the magnitudes of its
  /// terms. A difference below 1e-6 is always allowed.
  double cost = 1e-4;
  /// Open-loop deviation from the plan at the end of a phase, relative. Exceeding it alone
  /// changes only the message. The plan fails if `integration` is exceeded too, unless the system
  /// amplifies state errors tenfold or more.
  double open_loop = 1e-3;
  /// Open-loop violation of an end constraint, as a multiple of its tolerance. Exceeding it changes
  /// the message if the system amplifies state errors tenfold or more.
  static constexpr double open_loop_end = 100.0;
  /// Largest earlier crossing of zero by the guard that ends a phase, relative to its largest
  /// value.
  double crossing = 1e-2;
};

/// Result of a verification. It uses only the definition of the problem and the plan.
struct Verification {
  /// The largest violation of one kind and its tolerance.
  struct Miss {
    std::string phase = {};  ///< name of the phase; empty: the whole problem
    std::string term = {};   ///< name of the term, state, link or integral
    double time = 0.0;       ///< time in seconds of the largest violation
    double amount = 0.0;     ///< violation in the units of the term; 0: none
    double tolerance = 0.0;  ///< tolerance in the same units

    /// True if the violation exceeds its tolerance or is NaN.
    bool is_beyond() const { return !(amount <= tolerance); }
  };

  /// Defect of an interval: the planned state at its end minus the solution of the differential
  /// equation from the planned state at its start.
  ///
  /// Narrow peaks of the dynamics are located, like those of running costs. With algebraic states,
  /// events inside the phase or functions that are not C++ formulas, a peak between the stages of
  /// the verifier's integrator may be missed.
  struct Defect {
    std::string phase;      ///< phase of the largest defect
    int state = 0;          ///< index of its state
    double time = 0.0;      ///< start of its interval in seconds
    double largest = 0.0;   ///< relative to max(unit of the state, |state|)
    double absolute = 0.0;  ///< the same in the state's units
    double sum = 0.0;       ///< sum over all intervals, of the worst state of each phase, relative
  };

  /// Open loop: the planned inputs integrated from the planned start, through jumps, to the end.
  struct OpenLoop {
    bool completed = false;  ///< false: the integration failed, or a phase could not be verified
    double states = 0.0;     ///< largest deviation from the plan at the end of a phase, relative
    int state = 0;           ///< index of its state
    std::string phase;       ///< its phase
    double time = 0.0;       ///< end of that phase in seconds
    /// The end constraint with the largest violation in open loop.
    Miss end;
    /// Largest growth factor of a state error from the start along the plan, in units of the
    /// states: the largest singular value of the flow.
    double growth = 1.0;
  };

  /// The cost by the verifier's own quadrature.
  struct Cost {
    bool compared = false;    ///< false: a phase could not be verified
    double value = 0.0;       ///< cost in the user's units
    double difference = 0.0;  ///< difference to the reported cost, relative to its contributions
  };

  Miss between_nodes;      ///< path constraints at all times
  Miss at_nodes;           ///< all hard rows at the nodes of the program
  Defect defect;           ///< integration error of the plan
  OpenLoop open_loop;      ///< result of the inputs without feedback
  Cost cost;               ///< cost of the plan
  std::string integrator;  ///< schemes that the verifier used
  /// A sentence for each part that could not be verified; empty: everything was verified.
  std::vector<std::string> not_verified;
  double seconds = 0.0;  ///< wall-clock time of the verification
};

}  // namespace saltus
