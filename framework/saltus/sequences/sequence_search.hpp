// Best-first branch and bound over the beginnings of sequences, for convex problems in sampled time
// (piecewise affine, mixed logical): the optimum over all sequences, with a certificate.
//
// A node fixes the modes of the first phases; the others are relaxed to the hull of what may follow
// (mode_stages.cpp), so that its quadratic program is a lower bound on every sequence that begins
// so. In receding horizon the leaves of the last tick, one phase shorter, cover all sequences of
// the next one, and their bounds are moved along by duality: framework/design/sequences.md.
#pragma once

#include <memory>
#include <vector>

#include "saltus/core/clock.hpp"
#include "saltus/qp/stage_qp_solver.hpp"
#include "saltus/sequences/mode_graph.hpp"
#include "saltus/sequences/sequence_result.hpp"

namespace saltus {

class ModeStages;
struct SetStage;
struct InputHold;

/// Best first search over sequences of modes.
class SequenceSearch {
 public:
  /// Throws DefinitionError: ModeGraph::check(), options that are none, or a problem that is not
  /// convex in sampled time, with the mode and the reason; search() takes those too.
  SequenceSearch(ModeGraph graph, SearchOptions options);
  SequenceSearch(SequenceSearch&&) noexcept;
  SequenceSearch& operator=(SequenceSearch&&) noexcept;
  ~SequenceSearch();

  /// From nothing but the state, at the graph's start time, and what was applied `before`: its mode
  /// goes on or is left. Throws DefinitionError when the state has another size or is not finite,
  /// as solve_next() does.
  SequenceResult solve(const VectorRef& state, ModeHistory before = {});
  /// The same from another time, s: the costs and constraints of the end may read it.
  SequenceResult solve(const VectorRef& state, ModeHistory before, double time);
  /// One phase later, and as much later in time: the first mode of the last result was applied and
  /// led to `state`. Takes over the tree of the last solve; without one, or where ends or entries
  /// are limited (what was ruled out by them may be allowed now), as solve(). After a solve that
  /// found nothing `before` stays.
  SequenceResult solve_next(const VectorRef& state);
  /// After so many seconds the best so far is handed out, with its gap.
  void set_deadline(double seconds) { options_.deadline = seconds; }
  /// The same after so many programs, which is the same on every machine.
  void set_max_nodes(long nodes) { options_.max_nodes = nodes; }

  /// What is searched.
  const ModeGraph& graph() const { return graph_; }
  /// What was applied before the horizon of the last solve.
  ModeHistory before() const { return before_; }
  /// Start time of the horizon of the last solve, s.
  double time() const { return time_; }

 private:
  // A dual point, stage by stage: what moves a bound to the next tick.
  struct Limit {  // of the state where a phase begins: normal' x against side
    VectorXd normal;
    double side = 0.0, multiplier = 0.0;
  };
  struct Dual {
    int depth = 0;                           ///< phases whose modes are fixed
    std::vector<VectorXd> costates;          ///< of the state to which phase k leads
    std::vector<double> values;              ///< L_k, of all phases but the first
    std::vector<std::vector<Limit>> limits;  ///< those with multipliers, of all but the first
  };
  struct Node {
    std::vector<int> path;
    double bound = -infinity;
    std::shared_ptr<const StagePoint> point;  // of the last ancestor that was solved
    std::vector<int> point_path;              // its modes
    bool point_is_shifted = false;            // its last phase is invented: no dual comes of it
    std::shared_ptr<const Dual> dual;         // what was moved from the last tick; else of `point`
    std::shared_ptr<const StagePoint> proof;  // multipliers that say why it is infeasible
  };

  std::vector<ModeSet> sets_of(const std::vector<int>& path) const;
  QpResult solve_program(const std::vector<int>& path, const Node* from);
  void settle_unit(QpResult& root);
  void fill_ends();
  void begin_at(double time);
  double relative_gap() const;
  double size_of(double cost) const;
  SequenceResult run(std::vector<Node> open, WallClock::time_point begin);
  bool choose(const Node& node, std::vector<int>& path);
  std::vector<Node> leaves_to_move();
  std::vector<Node> shifted(std::vector<Node> leaves);
  static std::vector<Limit> limits_at(const Stage& stage, const StagePoint::AtStage& at,
                                      const VectorXd& lower, const VectorXd& upper);
  std::shared_ptr<const StagePoint> shifted_proof(const StagePoint& from) const;
  bool is_proved(const std::vector<int>& path, const StagePoint& proof);
  void limits_of(const std::vector<ModeSet>& sets, int k, VectorXd& lower, VectorXd& upper);
  std::shared_ptr<const StagePoint> shifted_point(const StagePoint& from) const;
  double shifted_bound(const Dual& dual, ModeSet last, Dual& next);
  std::shared_ptr<const Dual> dual_of(const StagePoint& point, const std::vector<int>& path);
  std::vector<double> shares(const SetStage& stage, const StagePoint::AtStage& point) const;
  void accept(const std::vector<int>& path, double cost, SequenceResult& best) const;
  void finish(SequenceResult& result);
  Solution solve_sequence(const std::vector<int>& path) const;
  void confirm_plan(SequenceResult& result);
  void confirm_infeasible(SequenceResult& result);
  std::vector<std::vector<int>> some_sequences(std::size_t most) const;
  void check(const VectorRef& state) const;

  ModeGraph graph_;
  SearchOptions options_;
  std::unique_ptr<ModeStages> stages_;
  std::vector<ModeSet> successors_;  // of every mode
  ModeSet ends_ = 0;                 // the modes that may be the last
  StageQp qp_;
  StagePoint point_;
  std::unique_ptr<StageQpSolver> solver_;
  std::unique_ptr<StageQpSolver> fine_solver_;  // where the bound of a program is far off
  StageQp tail_qp_;
  StagePoint tail_point_;
  ModeSet tail_set_ = 0;  // what its stage holds
  std::unique_ptr<StageQpSolver> tail_solver_;
  std::vector<ModeSet> filled_;  // what the stages of qp_ hold

  std::vector<InputHold*> holds_;  // of the stages of qp_
  double unit_ = 1.0;              // costs of the programs are divided by it
  double least_unit_ = 1.0;        // in units of the cost
  double least_cost_ = 1.0;        // in units of the cost
  double dual_bound_ = 0.0;        // of the last program that was solved

  VectorXd start_;  // scaled
  double time_;     // when the horizon begins, s
  WallClock::time_point deadline_ = WallClock::time_point::max();
  ModeHistory before_;        // what was applied before the horizon
  std::vector<Node> leaves_;  // that cover all sequences of the last solve
  std::vector<int> best_;
  double solver_seconds_ = 0.0;  // of this solve
  std::shared_ptr<const StagePoint> best_point_;
};

}  // namespace saltus
