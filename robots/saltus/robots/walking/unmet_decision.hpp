// Keeps decisions that could not satisfy all constraints, for explanations after the run.
#pragma once

#include <string>
#include <vector>

#include "saltus/robots/walking/run_log.hpp"

namespace saltus::robots::walking {

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

}  // namespace saltus::robots::walking
