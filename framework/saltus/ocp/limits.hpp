// What a number of the whole problem, an integral or a link, is held to: bounds, or a penalty
// beyond them.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/ocp/penalty.hpp"

namespace saltus {

/// Bounds on every row, one serves all; with a penalty a violation is possible and is paid once.
struct Limits {
  std::vector<Bounds> bounds;                  ///< one for all rows, or one per row
  std::optional<Penalty> soft = std::nullopt;  ///< hard if empty

  Limits() = default;
  /// The same for all rows, hard.
  Limits(Bounds all) : bounds{all} {}  // NOLINT(google-explicit-constructor)
  /// The same for all rows, soft.
  Limits(Bounds all, Penalty penalty) : bounds{all}, soft(std::move(penalty)) {}
  /// One per row, hard.
  Limits(std::vector<Bounds> rows)
      : bounds(std::move(rows)) {}  // NOLINT(google-explicit-constructor)
  /// One per row, soft.
  Limits(std::vector<Bounds> rows, Penalty penalty)
      : bounds(std::move(rows)), soft(std::move(penalty)) {}
};

}  // namespace saltus
