// Penalties on violations of soft constraints. Only this file and penalty.cpp know the kinds of
// penalties.
#pragma once

#include <optional>
#include <string>
#include <utility>

namespace saltus {

/// A penalty on the violation v >= 0 of a row. A running penalty is a rate: each node contributes
/// its cost times the length of an interval, with either CostRule, because rows exist at nodes
/// only. A penalty at the start or end of a phase is charged once.
///
/// To add a kind, add an enumerator here and a case in every `switch` of penalty.cpp: cost, slack
/// variables, valid parameters. Everything else (variables, curvature, weights on the grid, stages,
/// reports) follows from these.
struct Penalty {
  /// Cost as a function of the violation v.
  enum Kind {
    L1,    ///< weight v: exact, i.e. no violation if the weight exceeds the multiplier
    L2,    ///< weight/2 v^2: smooth, with a small violation at the optimum
    Huber  ///< L2 up to the threshold, then linear with slope weight * threshold
  };
  Kind kind = L1;          ///< kind of penalty
  double weight = 0.0;     ///< per unit of v (L1) or v^2, and per second if running
  std::string name = {};   ///< name by which the weight can be changed between solves
  double threshold = 0.0;  ///< for Huber, in units of v
};
/// A penalty with a name, so that its weight can be changed between solves.
inline Penalty soft(std::string name, double weight, Penalty::Kind kind = Penalty::L1) {
  return {kind, weight, std::move(name)};
}
/// A Huber penalty, robust to outliers: quadratic up to the threshold, linear above.
inline Penalty huber(std::string name, double weight, double threshold) {
  return {Penalty::Huber, weight, std::move(name), threshold};
}

/// Cost of a violation v >= 0.
double cost(const Penalty& penalty, double violation);

/// Describes invalid parameters. Empty if they are valid.
std::string describe_error(const Penalty& penalty);

/// Cost of one slack variable s: weight s or weight/2 s^2.
struct SlackCost {
  double weight = 0.0;        ///< factor of s or of s^2 / 2
  bool is_quadratic = false;  ///< true: weight/2 s^2
};

/// A penalty in terms of slack variables. Its cost is the minimum cost of slacks that satisfy
///
///     lower <= g + s_below - s_above + r <= upper,   s_below, s_above >= 0,
///
/// r is free. Some penalties do not need r.
struct PenaltySlacks {
  SlackCost side;                                ///< cost of s_below and of s_above
  std::optional<SlackCost> free = std::nullopt;  ///< cost of r; empty: no r
};
/// Slack variables of a penalty and their costs.
PenaltySlacks slacks_of(const Penalty& penalty);

}  // namespace saltus
