// Finds the first guard that a flow crosses in a step, also where it crosses back within the step.
//
// Guards and their rates are sampled at the ends of equal parts of each step. A change of sign is
// bracketed. Where a guard is negative at both ends of a part but its rate turns from positive to
// negative, its largest value inside is looked for: positive, it hides a pair of crossings, of
// which the first is taken; zero, the guard is touched.
#pragma once

#include <vector>

#include "saltus/integrators/hybrid_modes.hpp"
#include "saltus/integrators/hybrid_stepper.hpp"

namespace saltus {

/// Where a mode stands relative to one of its guards.
enum class GuardSide {
  inside,     ///< not yet crossed
  departing,  ///< on it at the start of the flow, and moving into the mode
  returning,  ///< behind it at the start of the interval, and moving back
};

struct LocatedCrossing {
  IntegrationStatus status = IntegrationStatus::success;
  int guard = -1;  ///< of the mode; -1: none was crossed
  double s = 0.0;
};

class EventLocator {
 public:
  EventLocator(FlowStepper& stepper, GuardEvaluator& guards, int states_and_costs, int most_guards);

  /// A flow begins in `mode` at (s, x); `sides` has one entry per guard.
  void begin(const FlowMode& mode, const std::vector<GuardSide>& sides, double s, const double* x);
  /// Looks through the stepper's last step. A guard that is reached at the end of the interval,
  /// s = 1, within rounding counts as crossed there.
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
