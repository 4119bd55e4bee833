// Limits of a quantity of the whole problem, an integral or a link: bounds, or a penalty outside
// them.
#pragma once

#include <optional>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/ocp/penalty.hpp"

namespace saltus {

/// Bounds on every row. With a penalty, a violation is allowed and charged once.
struct Limits {
  std::vector<Bounds> bounds;                  ///< one for all rows, or one per row
  std::optional<Penalty> soft = std::nullopt;  ///< empty: hard bounds

  Limits() = default;
  /// Hard bounds, the same for all rows.
  Limits(Bounds all) : bounds{all} {}  // NOLINT(google-explicit-constructor)
  /// Soft bounds, the same for all rows.
  Limits(Bounds all, Penalty penalty) : bounds{all}, soft(std::move(penalty)) {}
  /// Hard bounds, one per row.
  Limits(std::vector<Bounds> rows)
      : bounds(std::move(rows)) {}  // NOLINT(google-explicit-constructor)
  /// Soft bounds, one per row.
  Limits(std::vector<Bounds> rows, Penalty penalty)
      : bounds(std::move(rows)), soft(std::move(penalty)) {}
};

}  // namespace saltus
