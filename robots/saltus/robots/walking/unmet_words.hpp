// How what a planner could not keep to is told: what a problem on a biped knows of its own terms.
#pragma once

#include <string>

#include "saltus/robots/walking/unmet_decision.hpp"
#include "saltus/solve/explain.hpp"

namespace saltus::walking {

/// This one knows nothing: names of terms and numbers have to do.
class UnmetWords {
 public:
  virtual ~UnmetWords() = default;

  /// What is explained: with what counts beside the program's own constraints, such as limits of
  /// the verdict, as bounds. Unless said otherwise the problem of the tick.
  virtual OptimalControlProblem problem(const UnmetDecision& unmet) const { return unmet.problem; }
  /// What was added there, "the verdict's limits"; empty: nothing.
  virtual std::string limits(const UnmetDecision& /*unmet*/) const { return {}; }
  /// Whether a number may be proposed to change: not what was measured.
  virtual bool may_change(const UnmetDecision& /*unmet*/, const ProblemChange& /*change*/) const {
    return true;
  }
  /// What is missing, with directions; empty: the general sentence has to do.
  virtual std::string of(const UnmetDecision& /*unmet*/, const Shortage& /*shortage*/) const {
    return {};
  }
  /// What would help; empty: the general clause has to do.
  virtual std::string of(const UnmetDecision& /*unmet*/, const ProblemChange& /*change*/) const {
    return {};
  }
};

}  // namespace saltus::walking
