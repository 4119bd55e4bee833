// One named cost or constraint of a phase: its formula, its bounds or weights, when it acts.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/model/function.hpp"
#include "saltus/ocp/reference.hpp"
#include "saltus/ocp/window.hpp"

namespace saltus {

/// What a violation of a soft constraint costs. A running one is charged per unit of time (times
/// the length of the interval, like the running costs); one at the start or end of a phase once.
struct Penalty {
  enum Kind {
    L1,  ///< weight * violation: exact, no violation at all while the weight exceeds the multiplier
    L2   ///< weight / 2 * violation^2: smooth, always a little violation
  };
  Kind kind = L1;
  double weight = 0.0;  ///< per second of violation (running), per unit of violation^1 or ^2
  std::string name;     ///< under which the weight can be changed between solves
};
inline Penalty soft(std::string name, double weight, Penalty::Kind kind = Penalty::L1) {
  return {kind, weight, std::move(name)};
}

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
