// Best-first branch and bound over prefixes of sequences, for convex problems in sampled time
// (piecewise affine, mixed logical). Finds the optimum over all sequences with a certificate.
//
// A node fixes the modes of the first phases. The other phases are relaxed to the hull of possible
// modes (mode_stages.cpp). The quadratic program of a node is therefore a lower bound for all
// sequences with this prefix. In receding horizon, the leaves of the last tick, shortened by one
// phase, cover all sequences of the next tick. Duality carries their bounds over:
// framework/design/sequences.md.
#pragma once

#include <memory>
#include <vector>

#include "saltus/core/clock.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/sequences/mode_graph.hpp"
#include "saltus/sequences/search.hpp"

namespace saltus {

class ModeStages;
struct SetStage;
struct InputHold;

/// Best-first search over sequences of modes.
class SequenceSearch {
 public:
  /// Throws DefinitionError if the graph (ModeGraph::check()) or the options are invalid. Also
  /// throws, with mode and reason, if the problem is not convex in sampled time; search() handles
  /// those.
  SequenceSearch(ModeGraph graph, SearchOptions options);
  SequenceSearch(SequenceSearch&&) noexcept;
  SequenceSearch& operator=(SequenceSearch&&) noexcept;
  ~SequenceSearch();

  /// Solves from `state` at the graph's start time, without earlier results. The mode of `before`
  /// may continue or end. Throws DefinitionError if the state has the wrong size or is not finite,
  /// like solve_next().
  SequenceResult solve(const VectorRef& state, ModeGraph::History before = {});
  /// Same as above for a different start time in seconds, which conditions at the end may depend
  /// on.
  SequenceResult solve(const VectorRef& state, ModeGraph::History before, double time);
  /// Solves one phase later, after the first mode of the last result was applied and led to
  /// `state`. Reuses the tree of the last solve. Without one, or with limits on ends or entries, it
  /// works like solve(), because sequences excluded before may now be allowed. After a solve that
  /// found nothing, `before` is unchanged.
  SequenceResult solve_next(const VectorRef& state);
  /// Limits the wall-clock time per solve, s. The result is then the best sequence so far with its
  /// gap.
  void set_deadline(double seconds) { options_.deadline = seconds; }
  /// Limits the number of programs per solve. Unlike a deadline, it is reproducible on every
  /// machine.
  void set_max_nodes(long nodes) { options_.max_nodes = nodes; }

  /// The graph that is searched.
  const ModeGraph& graph() const { return graph_; }
  /// The mode applied before the horizon of the last solve.
  ModeGraph::History before() const { return before_; }
  /// Start time of the horizon of the last solve, s.
  double time() const { return time_; }

 private:
  struct Limit {  // bound on the state at the start of a phase: normal' x against side
    VectorXd normal;
    double side = 0.0, multiplier = 0.0;
  };
  // A dual point by stages, from which bounds for the next tick follow.
  struct Dual {
    int depth = 0;                           ///< number of phases with fixed modes
    std::vector<VectorXd> costates;          ///< costates of the state at the end of phase k
    std::vector<double> values;              ///< L_k, for all phases but the first
    std::vector<std::vector<Limit>> limits;  ///< active limits of all phases but the first
  };
  struct Node {
    std::vector<int> path;
    double bound = -infinity;
    std::shared_ptr<const qp::StagePoint> point;  // point of the last solved ancestor
    std::vector<int> point_path;                  // modes of that ancestor
    bool point_is_shifted = false;                // its last phase is extrapolated: gives no dual
    std::shared_ptr<const Dual> dual;             // dual from the last tick; null: use `point`
    std::shared_ptr<const qp::StagePoint> proof;  // multipliers that prove infeasibility
  };

  std::vector<ModeSet> sets_of(const std::vector<int>& path) const;
  qp::QpResult solve_program(const std::vector<int>& path, const Node* from);
  void settle_unit(qp::QpResult& root);
  void fill_ends();
  void begin_at(double time);
  double relative_gap() const;
  double size_of(double cost) const;
  SequenceResult run(std::vector<Node> open, WallClock::time_point begin);
  bool choose(const Node& node, std::vector<int>& path);
  std::vector<Node> reusable_leaves();
  std::vector<Node> shifted(std::vector<Node> leaves);
  static std::vector<Limit> limits_at(const qp::Stage& stage, const qp::StagePoint::AtStage& at,
                                      const VectorXd& lower, const VectorXd& upper);
  std::shared_ptr<const qp::StagePoint> shifted_proof(const qp::StagePoint& from) const;
  bool is_proved(const std::vector<int>& path, const qp::StagePoint& proof);
  void limits_of(const std::vector<ModeSet>& sets, int k, VectorXd& lower, VectorXd& upper);
  std::shared_ptr<const qp::StagePoint> shifted_point(const qp::StagePoint& from) const;
  double shifted_bound(const Dual& dual, ModeSet last, Dual& next);
  std::shared_ptr<const Dual> dual_of(const qp::StagePoint& point, const std::vector<int>& path);
  std::vector<double> shares(const SetStage& stage, const qp::StagePoint::AtStage& point) const;
  void accept(const std::vector<int>& path, double cost, SequenceResult& best) const;
  void finish(SequenceResult& result);
  Solution solve_sequence(const std::vector<int>& path) const;
  void confirm_plan(SequenceResult& result);
  void confirm_infeasible(SequenceResult& result);
  std::vector<std::vector<int>> sample_sequences(std::size_t most) const;
  void check(const VectorRef& state) const;

  ModeGraph graph_;
  SearchOptions options_;
  std::unique_ptr<ModeStages> stages_;
  std::vector<ModeSet> successors_;  // per mode
  ModeSet ends_ = 0;                 // the modes that may be last
  qp::StageQp qp_;
  qp::StagePoint point_;
  std::unique_ptr<qp::StageQpSolver> solver_;
  std::unique_ptr<qp::StageQpSolver> fine_solver_;  // for programs with a poor bound
  qp::StageQp tail_qp_;
  qp::StagePoint tail_point_;
  ModeSet tail_set_ = 0;  // mode set of its stage
  std::unique_ptr<qp::StageQpSolver> tail_solver_;
  std::vector<ModeSet> filled_;  // mode sets of the stages of qp_

  std::vector<InputHold*> holds_;  // limits of the stages of qp_
  double unit_ = 1.0;              // divisor of the costs of the programs
  double least_unit_ = 1.0;        // in units of the cost
  double least_cost_ = 1.0;        // in units of the cost
  double dual_bound_ = 0.0;        // bound of the last solved program

  VectorXd start_;  // scaled
  double time_;     // start of the horizon, s
  WallClock::time_point deadline_ = WallClock::time_point::max();
  ModeGraph::History before_;  // mode applied before the horizon
  std::vector<Node> leaves_;   // leaves that cover all sequences of the last solve
  std::vector<int> best_;
  double solver_seconds_ = 0.0;  // time of this solve
  std::shared_ptr<const qp::StagePoint> best_point_;
};

}  // namespace saltus
