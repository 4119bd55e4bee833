// Limits of a quantity of the whole problem, an integral or a link: bounds, or a penalty outside
// them.
#pragma once

#include <initializer_list>
#include <optional>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"
#include "saltus/ocp/penalty.hpp"

namespace saltus {

/// Bounds of each row: these values alone. `reach("there", state, exactly({2.0, 0.0}))`.
inline std::vector<Bounds> exactly(std::initializer_list<double> values) {
  std::vector<Bounds> bounds;
  for (const double value : values) bounds.push_back(exactly(value));
  return bounds;
}
/// The same for a vector.
inline std::vector<Bounds> exactly(const VectorXd& values) {
  std::vector<Bounds> bounds;
  for (const double value : values) bounds.push_back(exactly(value));
  return bounds;
}

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
  /// The same in braces: {exactly(0.0), at_least(1.0)}.
  Limits(std::initializer_list<Bounds> rows) : bounds(rows) {}
  /// Soft bounds, one per row.
  Limits(std::vector<Bounds> rows, Penalty penalty)
      : bounds(std::move(rows)), soft(std::move(penalty)) {}
};

}  // namespace saltus
