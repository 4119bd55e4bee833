// Rates at which the least relaxation of a problem decreases with its numbers: bounds, times,
// values.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "saltus/solve/least_relaxation.hpp"

namespace saltus {

/// A number that could change, and the rate of the relaxation.
struct Candidate {
  ProblemChange change;  ///< `by`: change to feasibility by linear extrapolation
  double slope = 0.0;    ///< derivative of the relaxation with respect to the number
  double before = 0.0;   ///< current value
  double scale = 1.0;    ///< current magnitude, or nominal value

  /// Relative size of the change.
  double effort() const { return std::abs(change.by) / scale; }
  /// True if the changed problem is still plausible: no value changes twentyfold, and data such as
  /// a mass or frequency keep their sign.
  bool is_credible() const;
};

/// Adds a number with its slope if the slope is significant.
void add_candidate(const OptimalControlProblem& problem, ProblemChange change, double slope,
                   double nominal, double relaxation, std::vector<Candidate>& candidates);

/// Candidates from the multipliers: bounds of terms, states, inputs, durations, unknowns and
/// the start, fixed durations, and data. Data use differences of the active constraints. `is_late`
/// ends the search early. Events are excluded because they move nodes.
std::vector<Candidate> find_candidates(const OptimalControlProblem& problem,
                                       LeastRelaxation& relaxed,
                                       const std::function<bool()>& is_late);

}  // namespace saltus
