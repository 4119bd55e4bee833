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

enum class TermKind {
  constraint,     ///< bounds on the formula
  cost,           ///< the formula itself, a scalar
  least_squares,  ///< 1/2 (r - ref)' W (r - ref) with r the formula
};
enum class TermDomain {
  running,      ///< all along its window
  phase_start,  ///< once, at x+ of the phase's first instant
  phase_end     ///< once, at x- of the phase's last instant
};

struct Term {
  std::string name;
  TermKind kind = TermKind::cost;
  TermDomain domain = TermDomain::running;
  Function function;           ///< z = (t | x | u | p)
  std::vector<Bounds> bounds;  ///< constraint: one per output
  std::optional<Penalty> soft = std::nullopt;
  MatrixXd weight;      ///< least_squares: symmetric positive semi-definite
  Reference reference;  ///< least_squares
  Window window = {};   ///< running terms only
};

}  // namespace saltus
