// The inside of StageMap: what is known of every variable and row, and per stage the lists of
// offsets along which numbers are written. Private to stage_map*.cpp.
#pragma once

#include <string>
#include <vector>

#include "saltus/qp/stage_map.hpp"

namespace saltus {
namespace stage_map {

enum class Kind { none, state, input, global, slack };
struct Variable {
  Kind kind = Kind::none;
  int stage = -1;  ///< of which it is a state or input; a global: where it is an input; a slack: -1
  int index = -1;  ///< among those states, inputs or globals; a slack: the row that it softens
  int last = -1;   ///< last stage that may use it
  int first = -1;  ///< first stage of a variable with which it shares an entry of the Hessian
  int chain = -1;  ///< the additional state that carries it, -1: none
  bool gone = false;  ///< at present its bounds are equal
  int column = -1;    ///< at present in (x, u) of its stage, -1: vanished
};
// A side of a row, or both; soft rows are two of these if both sides have a slack.
struct Part {
  int row = -1;
  int side = 0;  ///< -1 lower, 1 upper, 0 both
  int slack = -1;
  bool active = false;
  bool constant = false;  ///< all its variables vanished
  int group_row = -1;     ///< of the program in stages, -1: not in force
  double l1 = 0.0, l2 = 0.0;
};
// A slack and its entries in its row and in the Hessian (-1: none).
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
  bool in_force = false;  ///< some part is active
  std::vector<Part> parts;
  std::vector<int> variables;  ///< that may be columns
  std::vector<int> entries;    ///< of the rows, slacks left out
  std::vector<Move> M;
  std::vector<Fixed> fixed;  ///< `to` is a part
  std::vector<Move> twins;   ///< in M: the second side of a soft row, of direct rows
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
  std::vector<Entry> later;  ///< entries of a later stage: a is of this one, b of that
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

[[noreturn]] void fail(const std::string& what);  // of a structure: DefinitionError

}  // namespace stage_map

struct StageMap::Lists {
  using Kind = stage_map::Kind;
  using Variable = stage_map::Variable;
  using Part = stage_map::Part;
  using Slack = stage_map::Slack;
  using SoftRow = stage_map::SoftRow;
  using Fixed = stage_map::Fixed;
  using Move = stage_map::Move;
  using MovePair = stage_map::MovePair;
  using Group = stage_map::Group;
  using Entry = stage_map::Entry;
  using StagePlan = stage_map::StagePlan;
  using Coupling = stage_map::Coupling;

  Lists(const SparseQp& patterns, StageStructure structure);

  // Construction, what belongs where: stage_map_build.cpp.
  void assign_variables();
  void assign_rows(const SparseQp& patterns);
  void find_uses(const SparseQp& patterns);
  void assign_globals(const SparseQp& patterns);
  void assign_chains();
  // Construction, what each stage may hold: stage_map_plans.cpp.
  void make_plans(const SparseQp& patterns);
  void make_groups(const SparseQp& patterns, int stage, const StageStructure::Stage& given);
  void make_stages();

  // What is watched: stage_map_watch.cpp.
  void mark(int first, int last);
  StageFill watch(const SparseQp& qp);
  StageFill watch_soft(const SparseQp& qp, Part& part) const;
  bool hold_carried();

  // Lists of offsets: stage_map_lists.cpp.
  void make_lists(const SparseQp& qp);
  void count_columns(StagePlan& plan);
  int column(int variable, int stage) const;
  void list_cost(int stage);
  void list_dynamics(const SparseQp& qp, int stage);
  void list_groups(const SparseQp& qp, int stage);
  int resultant_size(int stage) const;

  // Numbers along the lists: stage_map_values.cpp.
  StageFill write(const SparseQp& qp);
  void write_cost(const SparseQp& qp, int stage);
  StageFill write_dynamics(const SparseQp& qp, int stage);
  StageFill write_groups(const SparseQp& qp, int stage);
  void write_bounds(const SparseQp& qp, int stage);
  StageFill write_start(const SparseQp& qp);
  const Slack& slack_of(const Part& part) const {
    const SoftRow& soft = soft_rows[soft_of_row[part.row]];
    return part.side < 0 ? soft.below : soft.above;
  }

  // Direct rows: stage_map_direct.cpp.
  void write_directly(SparseQp& qp, DirectRows& rows);
  void aim_dynamics(const SparseQp& qp, int stage);
  void aim_group(Group& group, RowGroup& target);
  void restart(const VectorXd& row_sides);

  // Points: stage_map_points.cpp.
  void to_sparse(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to);
  void to_stages(const SparseQp& qp, const PrimalDualPoint& from, StagePoint& to);
  void give_slacks(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to);
  double missed_in_stage(int stage, int group, const Part& part, const StagePoint& from) const;
  double slope_of(const SparseQp& qp, const Slack& slack, const PrimalDualPoint& at) const;
  double row_value(const SparseQp& qp, int row, const VectorXd& w) const;
  void compute_gradient(const SparseQp& qp, const PrimalDualPoint& at);
  double costate(const StagePoint& point, int stage, int x) const;

  StageStructure structure;
  int front = 0;  // stages put in front
  std::vector<Variable> variables;
  std::vector<int> row_stage;  // of groups and dynamics; -1: start rows
  std::vector<int> row_first;  // first stage of its variables
  std::vector<char> row_active;
  std::vector<SoftRow> soft_rows;
  std::vector<int> soft_of_row;  // -1: hard
  std::vector<int> start_entry;  // of the start rows
  std::vector<StagePlan> plans;
  std::vector<Coupling> couplings;
  std::vector<int> removable;  // inputs and globals
  int chains = 0;
  bool any_gone = false, any_fixed_value = false;
  std::vector<int> position;  // per column of a stage: work space
  StageQp stages;
  VectorXd gradient;

  DirectRows* direct = nullptr;      // null: entries of rows are those of the sparse program
  double* aside = nullptr;           // where entries go that stand in no stage
  std::vector<EntryTarget> targets;  // of every entry
  VectorXd row_values;               // work space
};

}  // namespace saltus
