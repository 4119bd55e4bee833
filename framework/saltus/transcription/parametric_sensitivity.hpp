// Derivatives of a program with respect to a number that is not one of its variables.
#pragma once

#include <functional>

#include "saltus/solver/optimum_system.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// Derivatives with respect to theta, at fixed w and multipliers.
struct ParametricRates : OptimumRates {
  double objective = 0.0;  ///< derivative of the cost
  double error = 0.0;      ///< estimate, relative to 1 + the largest entry of its kind
};

/// Range of the first step of an extrapolation.
struct StepRange {
  double first = 0.0, smallest = 0.0;  ///< largest and smallest first step
};

/// Outcome of difference().
enum class DifferenceStatus {
  success,
  other_terms,  ///< different terms are active on the two sides, for every step
  kink          ///< the same terms are active, but one-sided slopes differ
};

/// Central differences over steps h, h/2, h/4, ... extrapolated to h = 0 (Richardson; C. J. F.
/// Ridders, Adv. Eng. Software 4, 1982). `move(d)` changes the program to theta + d. Stops when the
/// values agree to the last digits or rounding dominates. h begins at `steps.first`. It shrinks
/// while the program at theta +- h has other active terms, cannot be evaluated or is refused.
DifferenceStatus difference(ShootingProgram& program, const OptimumSystem& optimum, StepRange steps,
                            const std::function<void(double)>& move, ParametricRates& rates);

}  // namespace saltus
