// A phase that ends where its guard passes zero: what decides its duration, and whether the guard
// can decide it at all.
//
// The end is the condition g(t, x-) = 0. It defines the time of the event only where the guard
// crosses zero with a rate,
//     dg/dt = g_t + g_x f(t, x-, u) != 0     (transversality),
// because dt/dx = -g_x / (g_t + g_x f). With the rate zero the trajectory grazes the surface, and
// the event time has no derivative (framework/design/conventions.md).
#pragma once

#include <string>

#include "saltus/core/bounds.hpp"
#include "saltus/model/crossing.hpp"
#include "saltus/model/function.hpp"

namespace saltus {

struct PhaseDefinition;

/// What ends a phase by its state.
struct EndGuard {
  std::string event;                      ///< its name, for messages and tables
  Function guard;                         ///< z = (t | x | u | p) -> one number; must not read u
  Crossing crossing = Crossing::falling;  ///< direction in which the guard passes zero
};

/// Rate of a guard along the dynamics, in the guard's units per second.
struct GuardRate {
  double value = 0.0;  ///< of the guard's change in time, units of the guard per s
  /// Size of what it is made of, |g_t| + |g_x N| |N^-1 f| with the nominal states N.
  double scale = 0.0;

  /// Below this fraction of the scale the crossing counts as grazing: the event time would carry
  /// errors of the state a million times enlarged.
  static constexpr double grazing_fraction = 1e-6;
  /// Whether the guard touches zero without passing through.
  bool grazes() const;
};
/// At z = (t | x- | u | p) of the phase, with the field that is in force there. Allocates.
GuardRate guard_rate(const PhaseDefinition& phase, const Function& dynamics, const Function& guard,
                     const VectorRef& z);

/// Throws DefinitionError naming phase and event when the guard cannot end the phase: its duration
/// is fixed, the guard is not one number, or it never crosses zero in that direction because the
/// dynamics, of no mode, move it (tried at seeded points around the guesses, within the bounds).
/// `start`: when the phase may begin, s.
void check_end_guard(const PhaseDefinition& phase, const EndGuard& guard, const Bounds& start);

}  // namespace saltus
