// A decision that could not keep to all that is asked of it, as it was asked: for explain()
// (saltus/solve/explain.hpp), when the run is over.
#pragma once

#include <string>
#include <vector>

#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus::walking {

/// What a planner was to solve in one tick.
struct UnmetDecision {
  std::string decision;           ///< "wrenches" or "steps"
  double time = 0.0;              ///< s
  double missed = 0.0;            ///< m; infinite: there was no plan at all
  OptimalControlProblem problem;  ///< with the data of the tick, from `time` on
  ShootingOptions shooting;       ///< its grid and its integrator
};

/// Keeps the first and the worst of each kind. Allocates: when the tick's input is out.
class UnmetDecisions {
 public:
  /// What `shooting` has solved last.
  void keep(const std::string& decision, double time, double missed,
            const MultipleShooting& shooting);
  /// In the order of time.
  std::vector<UnmetDecision> take();

 private:
  std::vector<UnmetDecision> kept_;  // of each kind the first, then the worst if that is another
};

}  // namespace saltus::walking
