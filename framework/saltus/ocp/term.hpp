// A named cost or constraint of a phase: formula, bounds or weights, and active window.
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

/// Role of a term in the problem.
enum class TermKind {
  constraint,     ///< bounds on the formula
  cost,           ///< the formula itself, a scalar
  least_squares,  ///< 1/2 (r - ref)' W (r - ref) with r the formula
};
/// Where a term applies.
enum class TermDomain {
  running,      ///< within its window
  phase_start,  ///< once, at x+ of the first instant
  phase_end     ///< once, at x- of the last instant
};

/// A cost or constraint of a phase, sizes at run time.
struct Term {
  std::string name;                            ///< name for messages and results
  TermKind kind = TermKind::cost;              ///< cost or constraint
  TermDomain domain = TermDomain::running;     ///< running, at the start or at the end
  Function function;                           ///< z = (t | x | u | p)
  std::vector<Bounds> bounds;                  ///< constraints: one per output
  std::optional<Penalty> soft = std::nullopt;  ///< empty: hard constraint
  MatrixXd weight;      ///< least_squares: symmetric positive semi-definite weight
  Reference reference;  ///< least_squares: the reference
  Window window = {};   ///< running terms: where the term applies
};

}  // namespace saltus
