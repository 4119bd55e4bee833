#include "saltus/ocp/phase.hpp"

#include <fmt/format.h>

#include <utility>

#include "saltus/core/error.hpp"

namespace saltus {
namespace {

// The switching system, with the phase's own dynamics as first mode.
SwitchingSystem& with_first_mode(PhaseDefinition& phase) {
  if (phase.switching.modes.empty())
    phase.switching.modes.push_back({phase.name, phase.dynamics, {}});
  return phase.switching;
}

}  // namespace

void add_surface(PhaseDefinition& phase, const std::string& event, Function guard, Function above) {
  SwitchingSystem& system = with_first_mode(phase);
  if (system.modes.size() > 1)
    throw DefinitionError(
        fmt::format("phase '{}', event '{}': the phase already has several modes, so it is "
                    "ambiguous which mode the surface divides; use an Automaton",
                    phase.name, event));
  const int below = 0, other = 1;
  system.modes.push_back(
      {fmt::format("{}, '{}' above zero", phase.name, event), std::move(above), {}});
  const std::size_t resets = system.transitions.size();
  for (std::size_t i = 0; i < resets; ++i) {  // the phase's events apply on both sides
    SwitchingSystem::Transition reset = system.transitions[i];
    reset.from = reset.to = other;
    system.transitions.push_back(std::move(reset));
  }
  system.transitions.push_back({event, below, other, guard, Crossing::rising, {}});
  system.transitions.push_back({event, other, below, guard, Crossing::falling, {}});
}

void add_reset(PhaseDefinition& phase, const std::string& event, Function guard, Crossing direction,
               Function reset) {
  SwitchingSystem& system = with_first_mode(phase);
  for (int mode = 0; mode < static_cast<int>(system.modes.size()); ++mode)
    system.transitions.push_back({event, mode, mode, guard, direction, reset});
}

}  // namespace saltus
