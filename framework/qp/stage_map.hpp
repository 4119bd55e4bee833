// From a sparse program whose stages are known to the program in stages, and points of either to
// points of the other.
#pragma once

#include <vector>

#include "saltus/core/primal_dual_point.hpp"
#include "saltus/qp/sparse_qp.hpp"
#include "saltus/qp/stage_qp.hpp"
#include "saltus/qp/stage_structure.hpp"

namespace saltus {

/// What became of the numbers of a sparse program.
enum class StageFill {
  filled,
  infeasible,  ///< a row of which every variable has equal bounds is violated
  /// Not expressible with these numbers: a row of the dynamics that is no equality, a slack with an
  /// upper bound or a negative penalty, or two variables carried into one stage as one state.
  not_staged
};

/// Variables with equal bounds, rows without bounds and slacks vanish; what is left is written into
/// the stages by lists of positions. The lists of a stage are made anew only where something in it
/// appeared or vanished. After construction nothing allocates.
///
/// Global variables are inputs of the stage before the first that uses them and states from there
/// on. If that is the first one, a stage is put in front in which nothing else happens.
///
/// The cost of a carried variable alone stays where the variable stands; where it is carried to,
/// only what it shares with others is left. The Hessian of one stage may thus be indefinite though
/// the program is convex: recursions over stages do not mind, solvers that expect every stage to be
/// convex do.
class StageMap {
 public:
  /// Throws DefinitionError if the structure does not fit the patterns, naming what does not.
  StageMap(const SparseQp& patterns, StageStructure structure);

  /// The program in stages as of the last fill(); its address stays.
  const StageQp& stages() const { return stages_; }
  StageFill fill(const SparseQp& qp) noexcept;

  // For the program of the last fill(), which must have succeeded.
  /// All variables and multipliers, those of vanished variables included. `to` is resized.
  void convert(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to) noexcept;
  /// `to` was made for stages(). Without multipliers in `from` those of `to` are zero.
  void convert(const SparseQp& qp, const PrimalDualPoint& from, StagePoint& to) noexcept;

 private:
  enum class Kind { none, state, input, global, slack };
  struct Variable {
    Kind kind = Kind::none;
    int stage = -1;  ///< where it stands; a global: where it is an input
    int index = -1;  ///< among the states or inputs of the stage, or among the globals
    int last = -1;   ///< last stage that may use it
    int first = -1;  ///< first stage of a variable that shares an entry of the Hessian
    int chain = -1;
    bool gone = false;
    int column = -1;  ///< present column in (x, u) of its stage, -1: vanished
  };
  // A side of a row, or both; soft rows are two of these if both sides have a slack.
  struct Part {
    int row = -1;
    int side = 0;  ///< -1 lower, 1 upper, 0 both
    int slack = -1;
    bool active = false;
    bool constant = false;  ///< all its variables vanished
    int at = -1;            ///< row of the group
    double l1 = 0.0, l2 = 0.0;
  };
  // Where a slack stands: its entries in its row and in the Hessian (-1: none).
  struct Slack {
    int variable = -1, entry = -1, hessian = -1;
  };
  struct SoftRow {
    Slack below, above;
  };
  struct Move {  // values[from] goes to data[to]
    int from, to;
  };
  struct MovePair {  // of a symmetric matrix
    int from, to, mirror;
  };
  struct Fixed {  // values[from] times the value of a vanished variable goes to entry `to`
    int from, to, variable;
  };
  struct Group {
    bool soft = false;
    std::vector<Part> parts;
    std::vector<int> variables;  ///< that may be columns
    std::vector<Move> M;
    std::vector<Fixed> fixed;  ///< `to` is a part
    VectorXd shift;            ///< of every part, by vanished variables and least slacks
  };
  struct Entry {  // of the Hessian
    int from, a, b;
  };
  struct StagePlan {
    bool is_front = false;
    std::vector<int> states, inputs, chosen;  ///< variables; chosen: globals that begin here
    std::vector<int> globals, chains;         ///< that may be states here
    std::vector<int> dynamics, diagonal;      ///< rows, and their entries of the next state
    std::vector<int> global_column, chain_column, holder;  ///< per global or chain, -1: none
    std::vector<Entry> hessian;
    std::vector<Entry> later;  ///< entries of a later stage: a stands here, b there
    std::vector<Group> groups;
    std::vector<int> resultants;
    int resultant_size = 0;
    int max_nx = 0, max_nu = 0;
    // Present lists.
    bool dirty = true;
    int nx = 0, nu = 0;
    std::vector<int> u_variable;  ///< of present inputs
    std::vector<MovePair> Q, R;
    std::vector<Move> S;
    std::vector<Fixed> cost_fixed;     ///< `to` in (x, u)
    std::vector<Entry> cost_constant;  ///< of two vanished variables
    struct Scaled {
      int from, to, row;
    };
    std::vector<Scaled> A, B;
    std::vector<Fixed> b_fixed;
    std::vector<double> scale;  ///< per row of the dynamics: -1 / entry of the next state
  };
  // An entry or row that joins a variable to a later stage.
  struct Coupling {
    int variable = -1, stage = -1;
    int hessian = -1, other = -1;  ///< entry and its other variable, or
    int row = -1;                  ///< a row
    bool on = false;
  };

  // Construction: stage_map_build.cpp.
  void place_variables();
  void place_rows(const SparseQp& patterns);
  void find_uses(const SparseQp& patterns);
  void place_globals(const SparseQp& patterns);
  void place_chains();
  void make_places(const SparseQp& patterns);
  void make_groups(const SparseQp& patterns, int stage, const StageStructure::Stage& given);
  void make_stages();

  // Filling: stage_map.cpp.
  void mark(int first, int last);
  StageFill watch(const SparseQp& qp);
  StageFill watch_soft(const SparseQp& qp, Part& part) const;
  bool hold_carried();
  void count_columns(StagePlan& plan);
  int column(int variable, int stage) const;
  void list_cost(int stage);
  void list_dynamics(const SparseQp& qp, int stage);
  void list_groups(const SparseQp& qp, int stage);
  int resultant_size(int stage) const;
  void write_cost(const SparseQp& qp, int stage);
  StageFill write_dynamics(const SparseQp& qp, int stage);
  StageFill write_groups(const SparseQp& qp, int stage);
  void write_bounds(const SparseQp& qp, int stage);
  void write_start(const SparseQp& qp);
  const Slack& slack_of(const Part& part) const {
    const SoftRow& soft = soft_rows_[soft_of_row_[part.row]];
    return part.side < 0 ? soft.below : soft.above;
  }

  // Points: stage_map_points.cpp.
  void give_slacks(const SparseQp& qp, PrimalDualPoint& to) const;
  void compute_gradient(const SparseQp& qp, const PrimalDualPoint& at);
  double costate(const StagePoint& point, int stage, int x) const;

  StageStructure structure_;
  int front_ = 0;  // stages put in front
  std::vector<Variable> variables_;
  std::vector<int> row_stage_;  // of groups and dynamics; -1: start rows
  std::vector<int> row_first_;  // first stage of its variables
  std::vector<char> row_active_;
  std::vector<SoftRow> soft_rows_;
  std::vector<int> soft_of_row_;  // -1: hard
  std::vector<int> start_entry_;  // of the start rows
  std::vector<StagePlan> plans_;
  std::vector<Coupling> couplings_;
  std::vector<int> removable_;  // inputs and globals
  int chains_ = 0;
  bool any_fixed_value_ = false;
  std::vector<int> position_;  // per column of a stage: work space
  StageQp stages_;
  VectorXd gradient_;
};

}  // namespace saltus
