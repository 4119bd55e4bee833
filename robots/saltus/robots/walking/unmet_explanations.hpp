// Interface for explanations of unmet constraints in terms of a problem on a biped.
#pragma once

#include <string>

#include "saltus/robots/walking/unmet_decision.hpp"
#include "saltus/solve/explain.hpp"

namespace saltus::walking {

/// Default: names of terms and numbers.
class UnmetExplanations {
 public:
  virtual ~UnmetExplanations() = default;

  /// The problem to explain, including bounds for criteria beyond its own constraints, such as
  /// limits of the verdict. Default: the problem of the tick.
  virtual OptimalControlProblem problem(const UnmetDecision& unmet) const { return unmet.problem; }
  /// Name of the added criteria, such as "the verdict's limits". Empty: none.
  virtual std::string limits(const UnmetDecision& /*unmet*/) const { return {}; }
  /// True if a number may be proposed for change. False for measured values.
  virtual bool may_change(const UnmetDecision& /*unmet*/, const ProblemChange& /*change*/) const {
    return true;
  }
  /// Description of what is missing, with directions. Empty: use the general sentence.
  virtual std::string of(const UnmetDecision& /*unmet*/, const Shortage& /*shortage*/) const {
    return {};
  }
  /// Description of a change that would help. Empty: use the general clause.
  virtual std::string of(const UnmetDecision& /*unmet*/, const ProblemChange& /*change*/) const {
    return {};
  }
};
/// Deprecated name.
using UnmetWords [[deprecated("use UnmetExplanations; removed in 0.4")]] = UnmetExplanations;

}  // namespace saltus::walking
