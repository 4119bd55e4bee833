// Finds the first guard crossing of a flow in a step, also if the guard crosses back within the
// step.
//
// Guards and their rates are sampled at the ends of equal parts of each step. A sign change
// brackets a crossing. If a guard is negative at both ends of a part and its rate changes from
// positive to negative, the maximum inside is computed. A positive maximum means a pair of
// crossings, of which the first counts. A zero maximum means that the trajectory touches the guard.
#pragma once

#include <vector>

#include "saltus/integrators/hybrid_modes.hpp"
#include "saltus/integrators/hybrid_stepper.hpp"

namespace saltus {

/// Position of the state relative to a guard of the mode.
enum class GuardSide {
  inside,     ///< not yet crossed
  departing,  ///< on the guard at the start of the flow, moving into the mode
  returning,  ///< beyond the guard at the start of the interval, moving back
};

struct LocatedCrossing {
  IntegrationStatus status = IntegrationStatus::success;
  int guard = -1;  ///< guard of the mode; -1: no crossing
  double s = 0.0;
};

class EventLocator {
 public:
  EventLocator(FlowStepper& stepper, GuardEvaluator& guards, int states_and_costs, int most_guards);

  /// Starts a flow in `mode` at (s, x). `sides` has one entry per guard.
  void begin(const FlowMode& mode, const std::vector<GuardSide>& sides, double s, const double* x);
  /// Searches the last step of the stepper. A guard reached at the end of the interval, s = 1, to
  /// rounding counts as crossed there.
  LocatedCrossing search();

 private:
  LocatedCrossing search_part(double a, double b);
  LocatedCrossing search_guard(int k, double a, double b);
  GuardSample at(int k, double s);
  double crossing(int k, double a, double b);
  double turning_point(int k, double a, double b);

  FlowStepper& stepper_;
  GuardEvaluator& guards_;
  const FlowMode* mode_ = nullptr;
  std::vector<double> y_;
  std::vector<GuardSide> sides_;
  std::vector<GuardSample> before_, after_;
};

}  // namespace saltus
