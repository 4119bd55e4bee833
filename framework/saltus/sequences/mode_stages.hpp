// Modes of a convex problem as stages of a quadratic program, one stage per phase. If the mode of a
// phase is undecided, its stage is the convex hull of the possible modes.
//
// A mode's stage comes from the transcription of its OptimalControlProblem. In the hull, every mode
// i has a copy (x_i, u_i) of state and input and a share mu_i:
//
//     x = sum x_i,  sum mu_i = 1,  mu_i >= 0,  x_next = sum (A_i x_i + B_i u_i + b_i mu_i),
//     l_i mu_i <= M_i (x_i, u_i) <= h_i mu_i
//
// See framework/design/sequences.md. x and mu of the last mode follow from the sums.
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

/// One phase of a mode. States are scaled by the nominal states of the first mode, inputs by those
/// of their own mode.
struct ModeStage {
  qp::Stage stage;                ///< includes conditions at its end, except state bounds
  VectorXd end_lower, end_upper;  ///< bounds of the state at its end
  std::shared_ptr<MultipleShooting> shooting;  ///< the transcription behind it
  std::shared_ptr<qp::StageMap> map;
  std::shared_ptr<qp::SparseQp> qp;
};

/// Origin of a row of the hull: row `row` of group `group`, or with group -1 a bound of entry `row`
/// of (x, u). It is one side, or both sides of an equality.
struct HullRow {
  int group = -1, row = 0;
  bool upper = false, equality = false;
};
struct HullMode {
  int mode = 0;
  int first = 0;  ///< index of its inputs (x_i, u_i, mu_i); only u_i for the last mode
  int nu = 0;
  std::vector<HullRow> rows;  ///< rows of the group at the same position; mu_i >= 0 is the last
};
struct SetStage {
  qp::Stage stage;
  VectorXd end_lower, end_upper;
  std::vector<HullMode> modes;  ///< empty for a single mode
  InputHold hold;               ///< limits of its inputs
};

class ModeStages {
 public:
  /// Transcribes every mode, and the end of a sequence of `phases` phases from the graph's start
  /// time. reason() states why the problem is unsuitable and is empty if it is suitable. A suitable
  /// problem is convex, quadratic and, except for its end, time-invariant. It has fixed durations,
  /// equal states in all modes and no jumps.
  ModeStages(const ModeGraph& graph, const IntegratorChoice& integrator, int phases);
  const std::string& reason() const { return reason_; }
  /// Transcribes the end again for a last phase that begins at this time, s. Throws DefinitionError
  /// if the end is not convex there.
  void end_after(const ModeGraph& graph, double begin_of_last);

  /// `first` selects the phase at the given start, where state bounds do not apply.
  SetStage& of(ModeSet set, bool first);
  const ModeStage& mode(int i) const { return free_[i]; }
  /// The last stage: the conditions at the end. It has only their bounds.
  const qp::Stage& end() const { return end_; }
  /// Modes that are infeasible for every state and input, because a row of data alone fails.
  ModeSet impossible() const { return impossible_; }
  /// False if a condition at the end fails that does not depend on the state, e.g. one on time
  /// alone.
  bool is_end_feasible() const { return end_feasible_; }
  /// Largest coefficient of all costs in nominal units, without penalty weights. 1 without costs.
  double largest_cost() const;
  /// Divides all costs by this number. Invalidates references returned by of().
  void divide_costs(double by);
  /// True if the mode may begin at this start.
  bool admits(int mode, const VectorXd& scaled_start) const;

  int states() const { return static_cast<int>(nominal_.size()); }
  VectorXd scaled(const VectorRef& state) const { return state.cwiseQuotient(nominal_); }
  VectorXd physical(const VectorRef& state) const { return state.cwiseProduct(nominal_); }
  /// Physical input of a phase of the mode for the state x and the inputs u of its stage.
  VectorXd input(int mode, const VectorRef& x, const VectorRef& u, const VectorRef& end);

  /// A program of `phases` stages and an end, sized for the largest stages.
  qp::StageQp capacity(int phases, bool fixed_start);

 private:
  std::string stage(OptimalControlProblem problem, const std::string& name, ModeStage& made,
                    qp::StageFill& fill) const;
  std::string transcribe(const ModeGraph& graph, int mode, bool given_start);
  std::string transcribe_end(const ModeGraph& graph, double begin_of_last);
  SetStage hull(ModeSet set, bool first) const;

  IntegratorChoice integrator_;
  VectorXd nominal_;
  std::vector<ModeStage> given_, free_;
  ModeSet impossible_ = 0;
  bool end_feasible_ = true;
  double cost_unit_ = 1.0;  // divisor of the stage costs
  qp::Stage end_;
  std::map<std::pair<ModeSet, bool>, SetStage> sets_;
  ModeSet all_ = 0;
  std::string reason_;
};

/// Converts the point of a set's stage into a point of a subset's stage, to start a child node from
/// its parent.
void restrict_point(const SetStage& from, const qp::StagePoint::AtStage& point, const SetStage& to,
                    ModeSet to_set, qp::StagePoint::AtStage& restricted);

}  // namespace saltus
