// A named cost or constraint of a phase: formula, bounds or weights, and active window.
#pragma once

#include <initializer_list>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"
#include "saltus/model/function.hpp"
#include "saltus/ocp/schedule.hpp"

namespace saltus {

// Penalties on violations of soft constraints. Only this file and penalty.cpp distinguish the kinds
// of penalties.

/// A penalty on the violation v >= 0 of a row. A running penalty is a rate: each node contributes
/// its cost times the length of an interval, with either CostRule, because rows exist at nodes
/// only. A penalty at the start or end of a phase is charged once.
///
/// To add a kind that Penalty::Slacks can describe, add an enumerator here and a case in every
/// `switch` of penalty.cpp: cost, slack variables, valid parameters. Everything else (variables,
/// curvature, weights on the grid, stages, reports) follows from these.
struct Penalty {
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
  struct Slacks {
    SlackCost side;                                ///< cost of s_below and of s_above
    std::optional<SlackCost> free = std::nullopt;  ///< cost of r; empty: no r
  };

  /// Cost as a function of the violation v.
  enum Kind {
    L1,    ///< weight v: exact, i.e. no violation if the weight exceeds the multiplier
    L2,    ///< weight/2 v^2: smooth, with a small violation at the optimum
    Huber  ///< L2 up to the threshold, then linear with slope weight * threshold
  };
  Kind kind = L1;          ///< kind of penalty
  double weight = 0.0;     ///< per unit of v (L1) or v^2, and per second if running
  std::string name = {};   ///< name by which the weight can be changed between solves
  double threshold = 0.0;  ///< threshold of Huber, in units of v
};
/// Deprecated name.
using SlackCost [[deprecated("use Penalty::SlackCost; removed in 0.4")]] = Penalty::SlackCost;
/// Deprecated name.
using PenaltySlacks [[deprecated("use Penalty::Slacks; removed in 0.4")]] = Penalty::Slacks;
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

/// True if no violation remains for a large enough weight, as for L1. The cost then has a positive
/// slope at v = 0.
bool is_exact(const Penalty& penalty);

/// Describes invalid parameters. Empty if they are valid.
std::string describe_error(const Penalty& penalty);

/// Slack variables of a penalty and their costs.
Penalty::Slacks penalty_slacks(const Penalty& penalty);

// Limits of a quantity of the whole problem, an integral or a link: bounds, or a penalty outside
// them.

/// Bounds that fix each row to one of these values: `reach("there", state, exactly({2.0, 0.0}))`.
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

// Reference of a least-squares term: zero, a constant, or a trajectory in time.

/// A reference signal with m entries. Linear between samples, constant before the first and after
/// the last one.
class Reference {
 public:
  /// Zero, for any size.
  Reference();
  Reference(const Reference& other);
  Reference(Reference&& other) noexcept;
  Reference& operator=(const Reference& other);
  Reference& operator=(Reference&& other) noexcept;
  ~Reference();
  /// A constant.
  Reference(VectorXd value);  // NOLINT(google-explicit-constructor)
  /// Samples at increasing absolute times in seconds, one column of `values` per time. Throws
  /// DefinitionError if sizes differ or times do not increase.
  Reference(std::vector<double> times, MatrixXd values);

  /// True if it is zero at all times.
  bool is_zero() const { return values_.size() == 0; }
  /// True if it depends on time.
  bool varies() const { return times_.size() > 1; }
  /// True if all its numbers are finite.
  bool is_finite() const;
  /// Number of entries.
  int size() const { return static_cast<int>(values_.rows()); }
  /// Entry i at time t. NaN if t is NaN and the reference varies. Throws DefinitionError if there
  /// is no entry i.
  double at(double t, int i) const;
  /// Time derivative of entry i, right-sided at a sample.
  double rate(double t, int i) const;

 private:
  void check_entry(int i) const;
  int segment(double t) const;
  std::vector<double> times_;
  MatrixXd values_;
};

/// A cost or constraint of a phase, sizes at run time.
struct Term {
  /// Role of a term in the problem.
  enum class Kind {
    constraint,     ///< bounds on the formula
    cost,           ///< the formula itself, a scalar
    least_squares,  ///< 1/2 (r - ref)' W (r - ref) with r the formula
  };

  /// Part of the phase to which a term applies.
  enum class Domain {
    running,      ///< within its window
    phase_start,  ///< once, at x+ of the first instant
    phase_end     ///< once, at x- of the last instant
  };

  std::string name;                            ///< name for messages and results
  Kind kind = Kind::cost;                      ///< cost or constraint
  Domain domain = Domain::running;             ///< running, at the start or at the end
  Function function;                           ///< z = (t | x | u | p)
  std::vector<Bounds> bounds;                  ///< constraints: one per output
  std::optional<Penalty> soft = std::nullopt;  ///< empty: hard constraint
  MatrixXd weight;      ///< least_squares: symmetric positive semi-definite weight
  Reference reference;  ///< least_squares: the reference
  Window window = {};   ///< running terms: where the term applies
};
/// Deprecated name.
using TermKind [[deprecated("use Term::Kind; removed in 0.4")]] = Term::Kind;
/// Deprecated name.
using TermDomain [[deprecated("use Term::Domain; removed in 0.4")]] = Term::Domain;

}  // namespace saltus
