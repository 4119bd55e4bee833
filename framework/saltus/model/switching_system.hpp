// Dynamics with state-triggered events, once the formulas are erased: modes, and transitions
// between them where a guard crosses zero.
//
// In a mode every guard of a transition that leaves it is "not yet crossed": negative for a rising
// guard, positive for a falling one. Where a guard reaches zero, the transition is taken: the
// state jumps to the reset, if there is one, and the dynamics of the next mode hold. Two
// transitions without reset, one in each direction through the same guard, divide the state space
// into two fields; where both push into the surface the motion slides on it (Filippov).
// framework/design/events.md has the conventions and the sensitivities.
#pragma once

#include <string>
#include <vector>

#include "saltus/model/arguments.hpp"
#include "saltus/model/crossing.hpp"
#include "saltus/model/function.hpp"

namespace saltus {

/// Its parts are members: in a program that says `using namespace saltus` a Mode is the user's.
struct SwitchingSystem {
  /// One field: x' = dynamics(z), z = (t | x | u | p).
  struct Mode {
    std::string name;            ///< for messages and tables
    Function dynamics;           ///< nx outputs
    Function running_cost = {};  ///< nq outputs; empty: the running cost of the interval
  };
  /// mode `from` -> mode `to` where guard(z) crosses zero.
  struct Transition {
    std::string name;                       ///< of the event
    int from = 0;                           ///< index into modes
    int to = 0;                             ///< mode behind it
    Function guard;                         ///< 1 output
    Crossing direction = Crossing::rising;  ///< of the guard's zero that counts
    Function reset = {};  ///< x+ of z = (t | x- | u | p), nx outputs; empty: x+ = x-
  };

  SwitchingSystem();
  SwitchingSystem(const SwitchingSystem& other);
  SwitchingSystem(SwitchingSystem&& other) noexcept;
  SwitchingSystem& operator=(const SwitchingSystem& other);
  SwitchingSystem& operator=(SwitchingSystem&& other) noexcept;
  ~SwitchingSystem();

  std::vector<Mode> modes;  ///< the first is in force at the start
  std::vector<Transition>
      transitions;  ///< in the order of their declaration, which decides when two come at once
  /// The state that holds the number of the mode, so that it is remembered from interval to
  /// interval where the other states do not tell it; -1: the mode follows from the state.
  int memory = -1;

  /// Whether there are no events.
  bool empty() const { return transitions.empty(); }
  /// Index of the mode of this name, or -1.
  int mode_index(const std::string& name) const;
  /// Throws DefinitionError naming mode and event: sizes that do not match, modes that do not
  /// exist, a guard that depends neither on the state nor on time or input.
  void check(const Arguments& sizes, int nq) const;
};

}  // namespace saltus
