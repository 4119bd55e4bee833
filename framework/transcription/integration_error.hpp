// How far is the integration from the differential equation? Every interval of a solution
// integrated once more, by the same method with finer steps or tolerance.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "saltus/model/integrator.hpp"
#include "saltus/transcription/trajectory.hpp"

namespace saltus {

/// An estimate, by the difference to IntegratorScheme::refined(). Errors of states are relative to
/// their magnitude, |difference| / max(nominal, |state|); where no nominal magnitude is declared,
/// the largest along the plan stands for it if that is below 1.
struct IntegrationError {
  /// The errors of the single intervals added up, of the state where that is most: what the plan as
  /// a whole is off by where the dynamics neither damp nor enlarge errors. Infinite where the finer
  /// integration fails.
  double states = 0.0;
  /// The worst single interval.
  std::string phase;
  int state = 0;                  ///< where it is largest
  double time = 0.0;              ///< s, its start
  std::vector<double> intervals;  ///< of each piece of the trajectory, its worst state
};

/// Of the plan that `scheme` integrated, every interval from its own planned start; nothing if the
/// scheme is exact or offers nothing finer. Takes about as long as two evaluations of the dynamics.
/// Allocates.
std::optional<IntegrationError> integration_error(const IntegratorScheme& scheme,
                                                  const Trajectory& trajectory);

}  // namespace saltus
