// The rates at which a program changes with a number that is none of its variables.
#pragma once

#include <functional>

#include "saltus/solver/optimum_system.hpp"
#include "saltus/transcription/shooting_program.hpp"

namespace saltus {

/// Derivatives with respect to theta, at fixed w and multipliers.
struct ParametricRates : OptimumRates {
  double objective = 0.0;  ///< of the optimal cost, per unit of the parameter
  double error = 0.0;      ///< estimated, relative to 1 + the largest entry of its kind
};

/// From where to where the first step of an extrapolation may shrink.
struct StepRange {
  double first = 0.0, smallest = 0.0;  ///< of the steps of the differences
};

/// How a check by differences ended.
enum class DifferenceStatus {
  success,
  other_terms,  ///< not the same terms are in force on both sides, however small the step
  kink          ///< the same terms, but their slopes to either side differ
};

/// `move(d)` brings the program to theta + d. Central differences over steps h, h/2, h/4, ... are
/// extrapolated to h = 0 (Richardson; C. J. F. Ridders, Adv. Eng. Software 4, 1982), until they
/// agree to the last digits or rounding takes over. h begins at `steps.first` and shrinks while
/// the program at theta +- h has other terms in force, cannot be evaluated or is refused.
DifferenceStatus difference(ShootingProgram& program, const OptimumSystem& optimum, StepRange steps,
                            const std::function<void(double)>& move, ParametricRates& rates);

}  // namespace saltus
