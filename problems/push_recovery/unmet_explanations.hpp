// Explanations of unmet constraints of push recovery: the point, the distance and the direction.
#pragma once

#include <string>
#include <vector>

#include "problems/push_recovery/criteria.hpp"
#include "saltus/robots/walking/biped_problem.hpp"

namespace saltus::push_recovery {

/// Explanations of the wrench program include the verdict's limits on height and angular momentum,
/// because without these limits the model recovers from nearly any push. They propose changes of
/// times, places, limits and the state after a push, but not of other measured values.
class PushRecoveryExplanations final : public walking::UnmetExplanations {
 public:
  explicit PushRecoveryExplanations(const LimitsOnTheWay& limits) : limits_(limits) {}

  OptimalControlProblem problem(const walking::UnmetDecision& unmet) const override;
  std::string limits(const walking::UnmetDecision& unmet) const override;
  bool may_change(const walking::UnmetDecision& unmet, const ProblemChange& change) const override;
  std::string of(const walking::UnmetDecision& unmet,
                 const Explanation::Shortage& shortage) const override;
  std::string of(const walking::UnmetDecision& unmet, const ProblemChange& change) const override;

 private:
  std::vector<PhaseDefinition::ComponentBounds> limits_that_hold(
      const walking::UnmetDecision& unmet) const;

  LimitsOnTheWay limits_;
};

}  // namespace saltus::push_recovery
