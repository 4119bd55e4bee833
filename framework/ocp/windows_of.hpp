// The windows of everything that a phase restricts or costs.
#pragma once

#include <fmt/format.h>

#include <string>

#include "saltus/ocp/phase_definition.hpp"

namespace saltus {

/// visit(window, describe) for terms and bounds; describe() makes the name of whose it is.
template <class Visit>
void for_each_window(const PhaseDefinition& phase, Visit&& visit) {
  for (const Term& t : phase.terms) visit(t.window, [&] { return "term '" + t.name + "'"; });
  for (const ComponentBounds& b : phase.input_bounds)
    visit(b.window, [&] { return fmt::format("input {}", b.component); });
  for (const ComponentBounds& b : phase.state_bounds)
    visit(b.window, [&] { return fmt::format("state {}", b.component); });
}

}  // namespace saltus
