// What the violation of a soft constraint costs. Nothing else knows the kinds of penalties:
// how to add one is said below.
#pragma once

#include <optional>
#include <string>
#include <utility>

namespace saltus {

/// A penalty on the violation v >= 0 of a row. A running one is charged per unit of time: at each
/// node, times the length of an interval, under either CostRule, because rows exist at nodes only.
/// One at the start or end of a phase is charged once.
///
/// A further kind is an enumerator here and a case in every `switch` of penalty.cpp: what it costs,
/// which slack variables stand for it, what its numbers must satisfy. Everything else (variables,
/// curvature, weights on the grid, stages, reports) follows from these.
struct Penalty {
  /// What a violation costs as it grows.
  enum Kind {
    L1,    ///< weight v: exact, no violation at all while the weight exceeds the multiplier
    L2,    ///< weight/2 v^2: smooth, always a little violation
    Huber  ///< L2 up to the threshold, from there on with constant slope weight * threshold
  };
  Kind kind = L1;          ///< how the cost grows
  double weight = 0.0;     ///< per second (running), per unit of v (L1) or v^2
  std::string name = {};   ///< under which the weight can be changed between solves
  double threshold = 0.0;  ///< Huber: in units of v
};
/// A penalty whose weight can be changed by name between solves.
inline Penalty soft(std::string name, double weight, Penalty::Kind kind = Penalty::L1) {
  return {kind, weight, std::move(name)};
}
/// Forgives the outlier: quadratic up to the threshold, linear beyond it.
inline Penalty huber(std::string name, double weight, double threshold) {
  return {Penalty::Huber, weight, std::move(name), threshold};
}

/// What a violation v >= 0 costs.
double cost(const Penalty& penalty, double violation);

/// What is wrong with its numbers, empty if nothing.
std::string describe_error(const Penalty& penalty);

/// Cost of one slack variable s: weight s, or weight/2 s^2.
struct SlackCost {
  double weight = 0.0;        ///< per slack, or per its square
  bool is_quadratic = false;  ///< per its square
};

/// A penalty as costs of slack variables: the least cost at which
///
///     lower <= g + s_below - s_above + r <= upper,   s_below, s_above >= 0,
///
/// can be met is that of the penalty. r is free; where it is not needed, it does not exist.
struct PenaltySlacks {
  SlackCost side;                                ///< of s_below and of s_above
  std::optional<SlackCost> free = std::nullopt;  ///< of r
};
/// Which slack variables stand for it and what they cost.
PenaltySlacks slacks_of(const Penalty& penalty);

}  // namespace saltus
