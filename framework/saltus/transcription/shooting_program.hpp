// The program behind MultipleShooting: blocks, rows and slacks of each term, and their updates for
// new data, bounds and weights.
#pragma once

#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "saltus/model/integrator.hpp"
#include "saltus/ocp/cost_functions.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/block_program.hpp"
#include "saltus/transcription/grid.hpp"
#include "saltus/transcription/shooting_instances.hpp"

namespace saltus {

/// Built once (shooting_build.cpp, shooting_terms.cpp), with variables, rows and blocks for every
/// grid point at which a term may become active. commit() (shooting_data.cpp) then sets constants,
/// bounds and weights for new data, without changing sizes or patterns.
class ShootingProgram final : public BlockProgram {
 public:
  /// Transcribes the problem on these meshes, one per phase.
  ShootingProgram(OptimalControlProblem problem, const std::vector<Mesh>& meshes,
                  const IntegratorChoice& integrator, int threads = 1);
  qp::StageStructure stages() const override;
  int first_slack() const override { return first_slack_; }
  /// Includes the intervals whose integrator has no second derivatives.
  SparsityPattern curvature_pattern() const override;

  /// Data of the next solve.
  const ProblemData& data() const { return data_; }
  /// Applies the data of the next solve. Throws DefinitionError without a change if a number is
  /// invalid or bounds contradict each other. Updates only differences from data(). Allocates
  /// only if it throws.
  void commit(const ProblemData& next);
  /// Sets every penalty weight of this name. Returns false if there is none.
  bool set_penalty_weight(std::string_view weight_name, double weight);

  /// Limits the weights of linear penalties during a solve. Infinity restores the weights of the
  /// problem. An L1 penalty is exact for every weight above the multiplier of its row.
  void limit_linear_weights(double most);
  /// Slacks whose weight is currently lowered.
  std::vector<int> lowered_slacks() const;

  /// The transcribed problem.
  const OptimalControlProblem& problem() const { return problem_; }
  /// The intervals.
  const Grid& grid() const { return grid_; }
  /// The variables.
  const Layout& layout() const { return layout_; }

  /// One per phase. They evaluate the program's intervals and belong to the thread that uses the
  /// program.
  const std::vector<std::shared_ptr<Integrator>>& integrators() const { return integrators_; }
  /// One per phase, for trajectories. They are independent of the program.
  const std::vector<std::shared_ptr<const ReentrantIntegrator>>& reentrant_integrators() const {
    return reentrant_integrators_;
  }
  /// Per phase: integrated running costs, then integrals. Empty if there are none.
  const std::vector<SelectiveStack>& integrated_costs() const { return integrated_costs_; }
  /// The intervals with their blocks and rows.
  const std::vector<shooting::IntervalInstance>& interval_instances() const { return intervals_; }
  /// Rows of path and point constraints.
  const std::vector<shooting::RowInstance>& row_instances() const { return rows_; }
  /// Costs at nodes and ends.
  const std::vector<shooting::CostInstance>& cost_instances() const { return costs_; }
  /// Costs of changes of the input.
  const std::vector<shooting::ChangeInstance>& change_instances() const { return changes_; }
  /// Rows of links and integrals.
  const std::vector<shooting::LimitInstance>& limit_instances() const { return limits_; }
  const std::vector<shooting::LinkCost>& link_costs() const { return link_costs_; }
  /// Limits of an instance.
  const Limits& limits_of(const shooting::LimitInstance& instance) const;
  /// Name for messages: "phase 'burn', integral 'fuel'".
  std::string describe_limit(const shooting::LimitInstance& instance) const;
  /// First row that sets the integrals at the start of a phase, to zero or to their previous
  /// values.
  int integral_start_row(int phase) const { return integral_start_rows_[phase]; }
  /// Sets the integrals of w to the values of its states and inputs.
  void fill_integrals(VectorXd& w);
  /// First row of the fixed start, or -1.
  int start_row() const { return start_row_; }
  /// First row of the jump into a phase. The first phase has none.
  int jump_row(int phase) const { return jump_rows_[phase - 1]; }
  /// First row that connects the end of the last phase to the start of the first, or -1.
  int closing_row() const { return closing_row_; }
  int total_time_row() const { return total_time_row_; }  ///< -1 if there is none

  /// Absolute time of a grid point in seconds, with durations from w. Null: reference durations.
  double time_of(const shooting::GridPoint& point, const VectorXd* w) const;
  /// Start time of a phase at w, or of the initial guess if null, s.
  double start_of(int phase, const VectorXd* w) const;
  /// Duration of a phase at w, or of the initial guess if null, s.
  double duration_of(int phase, const VectorXd* w) const;
  /// Parameters of a phase at w, or of the initial guess if null.
  VectorXd parameters_of(int phase, const VectorXd* w) const;
  /// True if the state at this node is fixed.
  bool is_given_start(int phase, int node) const;
  /// Block that multiplies the cost of a slack by a free duration, or -1 if the slack has a
  /// separate cost.
  int penalty_block(int slack) const { return penalty_blocks_[slack - first_slack_]; }
  /// Cost of a slack at w.
  double slack_cost(int slack, const VectorXd& w);
  /// Active bounds of an input component over an interval.
  Bounds input_bounds(int phase, int interval, int component) const;

  std::string describe_row(int row) const override { return describe_row(row, nullptr); }
  /// Description with times for durations from w. Null: reference durations.
  std::string describe_row(int row, const VectorXd* w) const;
  std::string describe_variable(int variable) const override { return layout_.describe(variable); }

 private:
  // Times are a constant plus free durations with their coefficients.
  double known_start(int phase) const;
  double known_time(const shooting::GridPoint& point) const;
  std::vector<VariableCoefficient> start_coefficients(int phase) const;
  std::vector<VariableCoefficient> time_coefficients(const shooting::GridPoint& point) const;
  std::vector<VariableCoefficient> offset_coefficients(int phase, double slope) const;
  double interval_length(int phase, int k) const;

  void build_start();
  void build_phase(int j, const IntegratorChoice& choice);
  void build_intervals(int j, const Function& flow, int nq, const std::vector<int>& optional);
  void join_inputs(int j, int k, shooting::IntervalInstance& instance);
  void build_running(int j, int t, bool integrated);
  void build_changes(int j);
  int build_jump(const Jump& jump, int ends, int begins);  // returns the first row
  void build_total_time();
  void build_integral_start(int j);
  void build_integral_limits(int j);
  void build_link(int l);
  void build_slacks();
  void build_limit_slacks();
  void add_row_instance(int j, int t, const shooting::GridPoint& point, bool state_only);
  shooting::BlockInstance add_term_block(const Function& f, const shooting::GridPoint& point,
                                         std::vector<BlockOutput> outputs, bool with_length);
  int add_penalty_block(const shooting::RowInstance& instance, int slack, bool is_quadratic);
  std::vector<VariableCoefficient> duration_coefficients(int phases) const;
  int new_rows(int count, const std::string& what);

  // Proposed grid and bounds for new data: shooting_data.cpp, shooting_refresh.cpp.
  void propose(const ProblemData& next);
  void propose_input_bounds(int j);
  void propose_state_bounds(int j, bool given_start);
  void place_parameter(int phase, int i, double value);

  // Update everything that depends on data_ and grid_. They do not throw.
  void refresh();
  void refresh_times();
  void refresh_total_time();
  void place_data();
  void refresh_start();
  void refresh_bounds();
  void refresh_rows();
  void refresh_limits();
  void refresh_changes();
  void refresh_continuity();
  void refresh_costs();
  void charge_slack(int slack, const Penalty::SlackCost& cost, double fraction, double length);
  int paying_interval(const shooting::RowInstance& instance, const Grid::PhaseWindow& window) const;
  bool is_pinned(int phase, int interval, int component) const;

  OptimalControlProblem problem_;
  ProblemData data_;
  Grid grid_;
  Layout layout_;
  struct Proposal {
    Grid grid;
    VectorXd lower, upper;  // for variables before the slacks; only states and inputs are used
  };
  Proposal proposal_;

  int start_row_ = 0;
  int closing_row_ = -1;
  int first_slack_ = 0;
  std::vector<int> penalty_blocks_;  // per slack
  std::vector<char> is_lowered_;     // per slack: true if its weight is lowered
  double max_linear_weight_ = infinity;
  int total_time_row_ = -1;
  std::vector<int> jump_rows_;                            // into each phase but the first
  std::vector<std::shared_ptr<Integrator>> integrators_;  // per phase
  std::vector<std::shared_ptr<const ReentrantIntegrator>> reentrant_integrators_;  // per phase
  std::vector<SelectiveStack> integrated_costs_;                                   // per phase
  std::vector<shooting::IntervalInstance> intervals_;
  std::vector<shooting::RowInstance> rows_;
  std::vector<shooting::LimitInstance> limits_;
  std::vector<shooting::LinkCost> link_costs_;
  std::vector<int> integral_start_rows_;  // per phase
  std::vector<shooting::CostInstance> costs_;
  std::vector<shooting::ChangeInstance> changes_;
  std::vector<shooting::BlockInstance> placed_;  // every block with data arguments
  // Names of groups of rows for messages, by first row, with their grid point if any.
  struct RowGroup {
    int first = 0;
    std::string name;
    shooting::GridPoint point;
    bool has_point = false;
  };
  std::vector<RowGroup> row_groups_;
};

}  // namespace saltus
