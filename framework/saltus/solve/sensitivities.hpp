// How fast the least relaxation of a problem falls with its numbers: bounds, times, values.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "saltus/solve/least_relaxation.hpp"

namespace saltus {

/// A number that could change, and how fast the relaxation does so.
struct Candidate {
  ProblemChange change;  ///< `by`: where it would be met if it went on like that
  double slope = 0.0;    ///< of the relaxation, over the units of the number
  double before = 0.0;   ///< its value
  double scale = 1.0;    ///< the value before, or what is nominal for it

  /// Of moving it so far.
  double effort() const { return std::abs(change.by) / scale; }
  /// Whether that is still the same problem: not twenty times the value, and data keep their sign
  /// (a mass, a frequency).
  bool is_credible() const;
};

/// A number with its slope, if that says anything.
void add_candidate(const OptimalControlProblem& problem, ProblemChange change, double slope,
                   double nominal, double relaxation, std::vector<Candidate>& candidates);

/// From the multipliers: bounds of terms, states, inputs, durations, unknowns and the start, fixed
/// durations and data, the latter by differences of what multipliers hold. `is_late`: to leave
/// out the rest. Events are not among them, they move nodes.
std::vector<Candidate> candidates_of(const OptimalControlProblem& problem, LeastRelaxation& relaxed,
                                     const std::function<bool()>& is_late);

}  // namespace saltus
