// Modes of a convex problem as stages of a quadratic program: one phase, one stage. What stands for
// a phase whose mode is not decided is the convex hull of the modes that it may have.
//
// A mode's stage is that of its own OptimalControlProblem, transcribed as always. In the hull every
// mode i has a copy (x_i, u_i) of state and input and a share mu_i,
//
//     x = sum x_i,  sum mu_i = 1,  mu_i >= 0,  x_next = sum (A_i x_i + B_i u_i + b_i mu_i),
//     l_i mu_i <= M_i (x_i, u_i) <= h_i mu_i
//
// (framework/design/sequences.md). The last mode's x and mu follow from the sums.
#pragma once

#include <map>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "saltus/model/integrator.hpp"
#include "saltus/qp/stage_map.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/sequences/dual_bound.hpp"
#include "saltus/sequences/mode_graph.hpp"
#include "saltus/transcription/multiple_shooting.hpp"

namespace saltus {

/// One phase of a mode. States are in units of the first mode's nominal ones, inputs of their own.
struct ModeStage {
  Stage stage;                    ///< with what holds at its end, but for bounds of the state
  VectorXd end_lower, end_upper;  ///< bounds of the state at its end
  std::shared_ptr<MultipleShooting> shooting;  ///< from which it was made
  std::shared_ptr<StageMap> map;
  std::shared_ptr<SparseQp> qp;
};

/// A row of the hull and what it is of its mode: row `row` of group `group`, or a bound (-1) of
/// entry `row` of (x, u); one side, or both of an equality.
struct HullRow {
  int group = -1, row = 0;
  bool upper = false, equality = false;
};
struct HullMode {
  int mode = 0;
  int first = 0;  ///< of its inputs (x_i, u_i, mu_i); of the last mode of u_i alone
  int nu = 0;
  std::vector<HullRow> rows;  ///< of the group with the same place; mu_i >= 0 comes last
};
struct SetStage {
  Stage stage;
  VectorXd end_lower, end_upper;
  std::vector<HullMode> modes;  ///< of a single mode: empty
  InputHold hold;               ///< what holds its inputs
};

class ModeStages {
 public:
  /// Transcribes every mode, and the end of a sequence of `phases` phases from the graph's start
  /// time. What makes the problem unfit is said by reason(), empty if it is fit: convex, quadratic,
  /// time-invariant but for the end, of fixed durations and the same states, without jumps.
  ModeStages(const ModeGraph& graph, const IntegratorChoice& integrator, int phases);
  const std::string& reason() const { return reason_; }
  /// Transcribes the end anew for a last phase that begins at this time, s. Throws DefinitionError
  /// if the end is no longer convex there.
  void end_after(const ModeGraph& graph, double begin_of_last);

  /// `first`: of the phase that begins with the given start, where bounds of the state do not act.
  SetStage& of(ModeSet set, bool first);
  const ModeStage& mode(int i) const { return free_[i]; }
  /// The last stage: what holds at the end. Its bounds are those of nothing but that.
  const Stage& end() const { return end_; }
  /// Modes that no state and input can meet, because a row of data alone fails.
  ModeSet impossible() const { return impossible_; }
  /// False if a constraint of the end fails that depends on no state, such as one of time alone.
  bool end_is_possible() const { return end_is_possible_; }
  /// Largest coefficient of all costs in nominal units, penalty weights excepted; 1 without costs.
  double largest_cost() const;
  /// Divides all costs by this number. The sets that of() returned before are gone.
  void divide_costs(double by);
  /// Whether the start lies where the mode may begin.
  bool admits(int mode, const VectorXd& scaled_start) const;

  int states() const { return static_cast<int>(nominal_.size()); }
  VectorXd scaled(const VectorRef& state) const { return state.cwiseQuotient(nominal_); }
  VectorXd physical(const VectorRef& state) const { return state.cwiseProduct(nominal_); }
  /// Physical input of a phase of the mode from the state x and the inputs u of its stage.
  VectorXd input(int mode, const VectorRef& x, const VectorRef& u, const VectorRef& end);

  /// A program of `phases` stages and an end with the largest sizes there are.
  StageQp capacity(int phases, bool fixed_start);

 private:
  std::string stage(OptimalControlProblem problem, const std::string& name, ModeStage& made,
                    StageFill& fill) const;
  std::string transcribe(const ModeGraph& graph, int mode, bool given_start);
  std::string transcribe_end(const ModeGraph& graph, double begin_of_last);
  SetStage hull(ModeSet set, bool first) const;

  IntegratorChoice integrator_;
  VectorXd nominal_;
  std::vector<ModeStage> given_, free_;
  ModeSet impossible_ = 0;
  bool end_is_possible_ = true;
  double cost_unit_ = 1.0;  // costs of the stages are divided by it
  Stage end_;
  std::map<std::pair<ModeSet, bool>, SetStage> sets_;
  ModeSet all_ = 0;
  std::string reason_;
};

/// The point of one set's stage as one of a part of it: of what a node's parent knows.
void restrict_point(const SetStage& from, const StagePoint::AtStage& point, const SetStage& to,
                    ModeSet to_set, StagePoint::AtStage& restricted);

}  // namespace saltus
