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
  VectorXd radius;              ///< no feasible input is larger; may be infinite
};

class ModeStages {
 public:
  /// Transcribes every mode. What makes the problem unfit is said by reason(), empty if it is fit:
  /// convex, quadratic, of fixed durations and the same states, without jumps.
  ModeStages(const ModeGraph& graph, const IntegratorChoice& integrator);
  const std::string& reason() const { return reason_; }

  /// `first`: of the phase that begins with the given start, where bounds of the state do not act.
  const SetStage& of(ModeSet set, bool first);
  const ModeStage& mode(int i) const { return free_[i]; }
  /// The last stage: what holds at the end. Its bounds are those of nothing but that.
  const Stage& end() const { return end_; }
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
  std::string transcribe(const ModeGraph& graph, int mode, const IntegratorChoice& integrator,
                         bool given_start);
  SetStage hull(ModeSet set, bool first) const;

  VectorXd nominal_;
  std::vector<ModeStage> given_, free_;
  Stage end_;
  std::map<std::pair<ModeSet, bool>, SetStage> sets_;
  ModeSet all_ = 0;
  std::string reason_;
};

/// The point of one set's stage as one of a part of it: of what a node's parent knows.
void restrict_point(const SetStage& from, const StagePoint::AtStage& point, const SetStage& to,
                    ModeSet to_set, StagePoint::AtStage& restricted);

}  // namespace saltus
