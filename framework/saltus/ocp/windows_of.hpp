// The windows of everything that a phase restricts or costs.
#pragma once

#include <fmt/format.h>

#include <cmath>
#include <optional>
#include <string>

#include "saltus/ocp/phase_definition.hpp"

namespace saltus {

/// Whether a window's limit is a number of seconds, and not an event or as good as none.
inline bool is_number(const std::optional<Instant>& limit) {
  return limit && !limit->is_event() && std::isfinite(limit->seconds());
}

/// Whether it is one after the start of its clock: of a phase's clock it cuts the phase in two.
inline bool is_after_start(const std::optional<Instant>& limit) {
  return is_number(limit) && limit->seconds() > same_instant;
}

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
