// The optimal control problem: a start, phases in order, the jumps between them, and a schedule.
#pragma once

#include <initializer_list>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "saltus/model/named_parameters.hpp"
#include "saltus/ocp/link.hpp"
#include "saltus/ocp/phase.hpp"
#include "saltus/ocp/phase_definition.hpp"
#include "saltus/ocp/schedule.hpp"

namespace saltus {

/// How running costs (minimise(), track()) are accumulated over an interval. The rule does not
/// affect soft constraints, changes of inputs, integral constraints and costs at ends.
///
/// A sum at the nodes approximates the integral with an error of first order in the interval
/// length. With ten intervals, sums are off by 1 to 2 % where integrated costs are off by 0.1 %.
/// Use it to reproduce a discrete-time problem that is defined by such a sum. Phases with linear
/// inputs always integrate: a sum would not depend on the input at the end of an interval.
enum class CostRule {
  integrated,  ///< Integral, computed by the integrator together with the dynamics. The default.
  nodes        ///< Length of the interval times the cost at its start.
};

/// Hybrid optimal control problem: one or more phases in order. Copies are independent but share
/// the immutable formulas.
class OptimalControlProblem {
 public:
  /// The range of p of one phase that a name refers to.
  struct ParameterRange {
    int first = 0, size = 0;  ///< index of the first number, and number of entries
    const PhaseDefinition::ParameterBlock* block =
        nullptr;  ///< the declared block, owned by the phase
  };

  OptimalControlProblem(const OptimalControlProblem& other);
  OptimalControlProblem(OptimalControlProblem&& other) noexcept;
  OptimalControlProblem& operator=(const OptimalControlProblem& other);
  OptimalControlProblem& operator=(OptimalControlProblem&& other) noexcept;
  ~OptimalControlProblem();
  /// `name` appears in messages.
  explicit OptimalControlProblem(std::string name = "problem");

  /// Fixes the state at the start. It can be replaced between solves.
  OptimalControlProblem& start_at(VectorXd state);
  /// Fixes the state at the start by its entries: start_at({0, 0}).
  OptimalControlProblem& start_at(std::initializer_list<double> state);
  /// Frees the state at the start within bounds, with an initial guess.
  OptimalControlProblem& start_within(std::vector<Bounds> bounds, VectorXd guess);
  /// Fixes the absolute start time, s.
  OptimalControlProblem& start_time(double t);
  /// Frees the absolute start time within bounds, with an initial guess, s.
  OptimalControlProblem& start_time(Bounds bounds, double guess);

  /// Appends a copy of the phase. Its first state is the last state of the phase before it. Later
  /// changes to the phase have no effect.
  template <int nx, int nu, int np, int nz>
  OptimalControlProblem& then(const Phase<nx, nu, np, nz>& phase) {
    return append(Jump{}, phase.definition());
  }
  /// Appends a copy of the phase, entered through the jump.
  template <int nx, int nu, int np, int nz>
  OptimalControlProblem& then(const Phase<nx, nu, np, nz>& phase, Jump jump) {
    return append(std::move(jump), phase.definition());
  }

  /// Appends a phase whose sizes are known at run time, entered through the jump.
  OptimalControlProblem& then(const PhaseDefinition& phase, Jump jump = {}) {
    return append(std::move(jump), phase);
  }

  /// Makes the problem periodic: the first state equals the last state, or the jump applied to it.
  /// The start may then be free (start_within()).
  OptimalControlProblem& close(Jump jump = Jump{});

  /// Constrains a formula of ends of phases: states, absolute times, durations and parameters
  /// (EndValues). Its arguments are the ends in the given order.
  ///
  ///     ocp.link("up twice as long as down", [](const auto& up, const auto& down) {
  ///       return up.duration - 2.0 * down.duration; }, exactly(0.0), end_of(up), end_of(down));
  template <class F, class... Ends>
  OptimalControlProblem& link(std::string name, F formula, Limits limits, Ends... ends) {
    return add_link(
        make_link(std::move(name), std::move(formula), std::move(limits), std::move(ends)...));
  }

  /// Adds a link whose sizes are known at run time.
  OptimalControlProblem& link(Link link) { return add_link(std::move(link)); }

  /// Adds weight/2 |formula|^2 to the cost. `formula` takes one EndValues per end, as in link().
  /// The term is a link to zero with a quadratic penalty, whose weight set_penalty_weight(name,
  /// ...) sets.
  ///
  ///     ocp.track_link("equal steps", [](const auto& a, const auto& b) {
  ///       return a.duration - b.duration; }, 10.0, end_of(first), end_of(second));
  template <class F, class... Ends>
  OptimalControlProblem& track_link(std::string name, F formula, double weight, Ends... ends) {
    Limits limits(exactly(0.0), soft(name, weight, Penalty::L2));
    return link(std::move(name), std::move(formula), std::move(limits), std::move(ends)...);
  }

  /// Adds a scalar formula to the cost. It takes one EndValues per end, as in link().
  ///
  ///     ocp.minimise_link("imbalance", [](const auto& a, const auto& b) {
  ///       return cosh(a.x[0] - b.x[0]); }, end_of(first), end_of(second));
  template <class F, class... Ends>
  OptimalControlProblem& minimise_link(std::string name, F formula, Ends... ends) {
    Link cost = make_link(std::move(name), std::move(formula), Limits(), std::move(ends)...);
    cost.is_cost = true;
    return add_link(std::move(cost));
  }

  /// Sets the events and modes to which windows refer by name.
  OptimalControlProblem& schedule(Schedule schedule);
  /// Sets the rule for running costs. Default: the integral.
  OptimalControlProblem& costs(CostRule rule);
  /// Bounds the sum of all durations, s.
  OptimalControlProblem& total_time(Bounds bounds);

  /// The problem without its first `phases` phases. Call start_at() to set its first state. Throws
  /// DefinitionError if no phase remains, if the problem is periodic, or if an integral or a link
  /// couples removed and remaining phases.
  OptimalControlProblem after(int phases) const;

  /// Sets every penalty weight of this name. Returns false if there is none.
  bool set_penalty_weight(std::string_view weight_name, double weight);
  /// The schedule, to move events between solves.
  Schedule& editable_schedule() { return schedule_; }
  /// Phase j, for variants of a problem with a different bound or number. check() validates it
  /// again. Throws DefinitionError if there is no such phase, like all members that take an index.
  PhaseDefinition& editable_phase(int j);
  /// Link i, for the same purpose.
  Link& editable_link(int i);

  /// Name for messages.
  const std::string& name() const { return name_; }
  /// The phases in order.
  const std::vector<PhaseDefinition>& phases() const { return phases_; }
  /// jumps()[j] leads into phase j. The first entry is unused.
  const std::vector<Jump>& jumps() const { return jumps_; }
  /// The jump from the last phase to the first. Empty if the problem is not periodic.
  const std::optional<Jump>& closing() const { return closing_; }
  /// Bounds of the first state, one per state of the first phase.
  const std::vector<Bounds>& start_bounds() const { return start_bounds_; }
  /// Initial guess of the first state.
  const VectorXd& start_guess() const { return start_guess_; }
  double start_time() const { return start_time_; }  ///< s; if free, the initial guess
  /// Bounds of a free start time, s. Empty if the start time is fixed.
  const std::optional<Bounds>& start_time_bounds() const { return start_time_bounds_; }
  /// Constraints that couple ends of phases.
  const std::vector<Link>& links() const { return links_; }
  /// Index of the phase with this name. Throws DefinitionError with the nearest name if there is
  /// none or more than one.
  int phase_index(const std::string& phase) const;
  /// Events and modes.
  const Schedule& schedule() const { return schedule_; }
  /// The rule set by costs().
  CostRule cost_rule() const { return cost_rule_; }
  /// The rule that applies to a phase: phases with linear inputs always integrate.
  CostRule cost_rule(int phase) const;
  /// Bounds of the sum of all durations, s.
  Bounds total_time() const { return total_time_; }
  /// Bounds of entry i of an unknown, intersected over all phases that declare it.
  Bounds bounds_of_unknown(const std::string& name, int i) const;

  /// Checks every size. Throws DefinitionError with phase and term.
  void check() const;
  /// One sentence for each valid definition that looks like a mistake, with phase and term.
  /// Examples: a cost with the same value for every trajectory, an unused input, state or
  /// parameter. solve() adds them to the solution. Requires that check() passes.
  std::vector<std::string> warnings() const;

 private:
  const PhaseDefinition& phase_at(int j) const;
  OptimalControlProblem& append(Jump jump, const PhaseDefinition& phase);
  OptimalControlProblem& add_link(Link&& link);
  void check_times() const;
  void check_start() const;
  void check_parameters() const;
  void check_integrals() const;
  void check_links() const;

  std::string name_;
  std::vector<PhaseDefinition> phases_;
  std::vector<Jump> jumps_;
  std::optional<Jump> closing_;
  std::vector<Bounds> start_bounds_;
  VectorXd start_guess_;
  double start_time_ = 0.0;
  std::optional<Bounds> start_time_bounds_;
  std::vector<Link> links_;
  Schedule schedule_;
  CostRule cost_rule_ = CostRule::integrated;
  Bounds total_time_;
};
/// Deprecated name.
using ParameterRange [[deprecated("use OptimalControlProblem::ParameterRange; removed in 0.4")]] =
    OptimalControlProblem::ParameterRange;

// Sets data by the name of a parameter block ("road") or of one entry ("road.slope").

/// Returns nullopt if the phase has no such block or entry. Does not allocate.
std::optional<OptimalControlProblem::ParameterRange> find_parameter(const PhaseDefinition& phase,
                                                                    std::string_view name);

/// Throws DefinitionError unless `name` is data of the problem with `size` numbers. If the block
/// has named entries, they must match `entries` (empty: no check). The message lists the valid
/// names. Allocates only on error.
void check_data(const OptimalControlProblem& problem, std::string_view name, int size,
                std::span<const ParameterEntry> entries);

/// Setters for data, for a class Self with set_entries(name, values, entries).
template <class Self>
class DataByName {
 public:
  /// Sets a block or one entry of it, in the order of p. Matrices are row-major.
  void set_data(std::string_view name, const VectorRef& values) {
    self().set_entries(name, values, {});
  }
  /// Sets a single number.
  void set_data(std::string_view name, double value) { set_data(name, Vec<double, 1>(value)); }
  template <class Matrix>
  /// Sets a matrix of fixed size.
    requires(Matrix::RowsAtCompileTime > 0 && Matrix::ColsAtCompileTime > 1)
  void set_data(std::string_view name, const Eigen::MatrixBase<Matrix>& value) {
    constexpr int rows = Matrix::RowsAtCompileTime, cols = Matrix::ColsAtCompileTime;
    const Mat<double, cols, rows> by_rows = value.transpose();
    set_data(name, by_rows.template reshaped<Eigen::AutoOrder>().eval());
  }
  /// Sets a block declared by this struct.
  template <NamedParameters Block>
  void set_data(std::string_view block, const Block& value) {
    self().set_entries(block, packed(value), entries_of<Block>());
  }

 private:
  Self& self() { return static_cast<Self&>(*this); }
};

}  // namespace saltus
