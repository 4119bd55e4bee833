// Program of a decision that could not satisfy all constraints, kept for explain()
// (saltus/solve/explain.hpp) after the run.
#pragma once

#include <string>
#include <vector>

#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::walking {

/// Problem of a planner in one tick.
struct UnmetDecision {
  std::string decision;           ///< "wrenches" or "steps"
  double time = 0.0;              ///< s
  double missed = 0.0;            ///< total violation, m; infinite: no plan
  OptimalControlProblem problem;  ///< with the data of the tick, starting at `time`
  ShootingOptions shooting;       ///< grid and integrator
};

/// Keeps the first and the worst decision of each kind. Allocates; called after the input of the
/// tick is sent.
class UnmetDecisions {
 public:
  /// Records the last program of `shooting`.
  void keep(const std::string& decision, double time, double missed,
            const MultipleShooting& shooting);
  /// All decisions, sorted by time.
  std::vector<UnmetDecision> take();

 private:
  std::vector<UnmetDecision> kept_;  // the first of each kind, then the worst if it differs
};

}  // namespace saltus::walking
