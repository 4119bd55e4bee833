// Dynamics with state-triggered events after type erasure: modes, and transitions where a guard
// crosses zero.
//
// In a mode, the guard of every outgoing transition has not crossed yet: it is negative if rising,
// positive if falling. When a guard reaches zero, its transition is taken. The state jumps to the
// reset, if there is one, and the dynamics of the next mode become active. Two transitions without
// reset, one in each direction through the same guard, divide the state space into two fields.
// Where both point towards the surface, the trajectory slides on it (Filippov).
// framework/design/events.md has the conventions and the sensitivities.
#pragma once

#include <string>
#include <vector>

#include "saltus/model/function.hpp"

namespace saltus {

// Direction in which a guard crosses zero at its event.

/// Sign of the rate g_t + g_x f of a guard g(t, x, ...) at its event, before a jump.
enum class Crossing {
  rising,  ///< guard changes from negative to positive
  falling  ///< guard changes from positive to negative
};

/// Text for messages.
constexpr const char* describe(Crossing crossing) {
  return crossing == Crossing::rising ? "rising" : "falling";
}

/// +1 for rising, -1 for falling. crossing_sign(c) * rate is positive at an event in direction c.
constexpr double crossing_sign(Crossing crossing) {
  return crossing == Crossing::rising ? 1.0 : -1.0;
}

/// Type-erased modes and transitions of an automaton. Mode and Transition are members, so that
/// `using namespace saltus` leaves these names to the user.
struct SwitchingSystem {
  /// One field: x' = dynamics(z), z = (t | x | u | p).
  struct Mode {
    std::string name;            ///< name for messages and tables
    Function dynamics;           ///< nx outputs
    Function running_cost = {};  ///< nq outputs; empty: the running cost of the interval
  };
  /// A transition from mode `from` to mode `to` where guard(z) crosses zero.
  struct Transition {
    std::string name;                       ///< name of the event
    int from = 0;                           ///< index into modes
    int to = 0;                             ///< index of the mode after the event
    Function guard;                         ///< 1 output
    Crossing direction = Crossing::rising;  ///< direction of the zero crossing that triggers
    Function reset = {};  ///< x+ as a function of z = (t | x- | u | p), nx outputs; empty: x+ = x-
  };

  SwitchingSystem();
  SwitchingSystem(const SwitchingSystem& other);
  SwitchingSystem(SwitchingSystem&& other) noexcept;
  SwitchingSystem& operator=(const SwitchingSystem& other);
  SwitchingSystem& operator=(SwitchingSystem&& other) noexcept;
  ~SwitchingSystem();

  std::vector<Mode> modes;  ///< the first one is the default dynamics
  std::vector<Transition>
      transitions;  ///< in order of declaration; the first one wins if two events coincide
  /// Index of the state that stores the mode between intervals, for modes that do not follow from
  /// the other states. -1: the mode follows from the state.
  int memory = -1;

  /// True if there are no events.
  bool empty() const { return transitions.empty(); }
  /// Index of the mode with this name, or -1.
  int mode_index(const std::string& name) const;
  /// Appends a transition between modes with these names. Throws DefinitionError if there is none.
  void add_transition(const std::string& name, const std::string& from_mode,
                      const std::string& to_mode, Function guard, Crossing direction,
                      Function reset);
  /// Throws DefinitionError with mode and event if sizes do not match, a mode does not exist, or a
  /// guard depends on neither state, time nor input.
  void check(const Arguments& sizes, int nq) const;
};

}  // namespace saltus
