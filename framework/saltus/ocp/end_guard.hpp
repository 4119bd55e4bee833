// A phase that ends where its guard crosses zero, which determines its duration.
//
// The end condition is g(t, x-) = 0. It defines the event time only if the guard crosses zero with
// a non-zero rate,
//     dg/dt = g_t + g_x f(t, x-, u) != 0     (transversality),
// because dt/dx = -g_x / (g_t + g_x f). With zero rate, the trajectory grazes the surface, and the
// event time has no derivative (framework/design/conventions.md).
#pragma once

#include <string>

#include "saltus/core/bounds.hpp"
#include "saltus/model/crossing.hpp"
#include "saltus/model/function.hpp"

namespace saltus {

struct PhaseDefinition;

/// The guard that ends a phase.
struct EndGuard {
  std::string event;                      ///< name for messages and tables
  Function guard;                         ///< z = (t | x | u | p) -> one number; must not read u
  Crossing crossing = Crossing::falling;  ///< direction of the zero crossing
};

/// Rate of a guard along the trajectory, in the guard's units per second.
struct GuardRate {
  double value = 0.0;  ///< g_t + g_x f
  /// Scale of the rate: |g_t| + |g_x N| |N^-1 f| with the nominal states N.
  double scale = 0.0;

  /// Below this fraction of the scale, the crossing counts as grazing: errors of the state would be
  /// amplified a million times in the event time.
  static constexpr double grazing_fraction = 1e-6;
  /// True if the rate is too small, i.e. the guard touches zero without crossing.
  bool grazes() const;
};
/// Rate at z = (t | x- | u | p) of the phase, with the dynamics active there. Allocates.
GuardRate guard_rate(const PhaseDefinition& phase, const Function& dynamics, const Function& guard,
                     const VectorRef& z);

/// Throws DefinitionError with phase and event if the guard cannot end the phase. This is so if the
/// duration is fixed, if the guard is not a scalar, or if no dynamics of any mode move the guard in
/// the declared direction. The last check samples seeded points around the guesses within the
/// bounds. `start` bounds the start time of the phase, s.
void check_end_guard(const PhaseDefinition& phase, const EndGuard& guard, const Bounds& start);

}  // namespace saltus
