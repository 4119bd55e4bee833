// One named cost or constraint of a phase: its formula, its bounds or weights, when it acts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/model/function.hpp"
#include "saltus/ocp/penalty.hpp"
#include "saltus/ocp/reference.hpp"
#include "saltus/ocp/window.hpp"

namespace saltus {

/// What a term does to the program.
enum class TermKind {
  constraint,     ///< bounds on the formula
  cost,           ///< the formula itself, a scalar
  least_squares,  ///< 1/2 (r - ref)' W (r - ref) with r the formula
};
/// When a term acts.
enum class TermDomain {
  running,      ///< all along its window
  phase_start,  ///< once, at x+ of the phase's first instant
  phase_end     ///< once, at x- of the phase's last instant
};

/// A cost or constraint of a phase, sizes at run time.
struct Term {
  std::string name;                            ///< for messages and results
  TermKind kind = TermKind::cost;              ///< cost or constraint
  TermDomain domain = TermDomain::running;     ///< all the time, at the start, at the end
  Function function;                           ///< z = (t | x | u | p)
  std::vector<Bounds> bounds;                  ///< constraint: one per output
  std::optional<Penalty> soft = std::nullopt;  ///< hard if empty
  MatrixXd weight;                             ///< least_squares: symmetric positive semi-definite
  Reference reference;                         ///< least_squares
  Window window = {};                          ///< running terms only
};

}  // namespace saltus
