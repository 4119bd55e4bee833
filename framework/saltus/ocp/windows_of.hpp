// The windows of all terms and bounds of a phase.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

#include "saltus/ocp/phase_definition.hpp"

namespace saltus {

/// True if the limit is a finite number of seconds, not an event.
inline bool is_number(const std::optional<Instant>& limit) {
  return limit && !limit->is_event() && std::isfinite(limit->seconds());
}

/// True if the limit is a number after the start of its clock. A limit in phase time then cuts the
/// phase.
inline bool is_after_start(const std::optional<Instant>& limit) {
  return is_number(limit) && limit->seconds() > same_instant;
}

/// Calls visit(window, describe) for all terms and bounds. describe() returns the name of the
/// owner.
template <class Visit>
void for_each_window(const PhaseDefinition& phase, Visit&& visit) {
  for (const Term& t : phase.terms) visit(t.window, [&] { return "term '" + t.name + "'"; });
  for (const PhaseDefinition::ComponentBounds& b : phase.input_bounds)
    visit(b.window, [&] { return fmt::format("input {}", b.component); });
  for (const PhaseDefinition::ComponentBounds& b : phase.state_bounds)
    visit(b.window, [&] { return fmt::format("state {}", b.component); });
}

}  // namespace saltus
