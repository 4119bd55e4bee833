// Implementation data of StageMap: the properties of every variable and row, and per stage the
// lists of offsets for writing values. Private to stage_map*.cpp.
#pragma once

#include <string>
#include <vector>

#include "saltus/qp/stage_map.hpp"

namespace saltus::qp {
namespace stage_map {

enum class Kind { none, state, input, global, slack };
struct Variable {
  Kind kind = Kind::none;
  int stage = -1;     ///< stage of the state or input; a global: the stage where it is an input; a
                      ///< slack: -1
  int index = -1;     ///< index among those states, inputs or globals; a slack: its soft row
  int last = -1;      ///< last stage that may use it
  int first = -1;     ///< first stage of a variable with which it shares a Hessian entry
  int chain = -1;     ///< additional state that carries it; -1: none
  bool gone = false;  ///< true if its bounds are currently equal
  int column = -1;    ///< current column in (x, u) of its stage; -1: eliminated
};
// One side of a row, or both. A soft row has two parts if both sides have a slack.
struct Part {
  int row = -1;
  int side = 0;  ///< -1 lower, 1 upper, 0 both
  int slack = -1;
  bool active = false;
  bool constant = false;  ///< all its variables are eliminated
  int group_row = -1;     ///< row in the program in stages; -1: inactive
  double l1 = 0.0, l2 = 0.0;
};
// A slack and the indices of its entries in its row and in the Hessian (-1: none).
struct Slack {
  int variable = -1, entry = -1, hessian = -1;
};
struct SoftRow {
  Slack below, above;
};
struct Twin {  // M.data()[from] is also M.data()[to]
  int from, to;
};
// Destinations of a Hessian entry.
struct HessianTarget {
  double *to, *mirror;
};
struct Fixed {  // values[from] times the value of an eliminated variable goes to entry `to`
  int from, to, variable;
};
struct Group {
  bool soft = false;
  bool in_force = false;  ///< some part is active
  std::vector<Part> parts;
  std::vector<int> variables;  ///< possible columns
  std::vector<int> entries;    ///< row entries without slacks
  std::vector<Fixed> fixed;    ///< `to` is a part
  std::vector<Twin> twins;     ///< second sides of soft rows
  VectorXd shift;  ///< per part: contribution of eliminated variables and minimum slacks
};
struct Entry {  // entry of the Hessian
  int from, a, b;
};
struct StagePlan {
  bool is_front = false;
  std::vector<int> states, inputs, chosen;  ///< variables; chosen: globals that begin here
  std::vector<int> globals, chains;         ///< possible states of this stage
  std::vector<int> dynamics, diagonal;      ///< rows, and their entries of the next state
  std::vector<int> global_column, chain_column, holder;  ///< per global or chain; -1: none
  std::vector<Entry> hessian;
  std::vector<Entry> later;  ///< entries shared with a later stage: a belongs to this stage, b to
                             ///< the later one
  std::vector<Group> groups;
  std::vector<int> resultants;
  int resultant_size = 0;
  int max_nx = 0, max_nu = 0;
  // Current lists.
  bool dirty = true;
  int nx = 0, nu = 0;
  std::vector<int> u_variable;       ///< variables of the current inputs
  std::vector<Fixed> cost_fixed;     ///< `to` is an index into (x, u)
  std::vector<Entry> cost_constant;  ///< entries of two eliminated variables
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

[[noreturn]] void fail(const std::string& what);  // throws DefinitionError about the structure

}  // namespace stage_map

struct StageMap::Lists {
  using Kind = stage_map::Kind;
  using Variable = stage_map::Variable;
  using Part = stage_map::Part;
  using Slack = stage_map::Slack;
  using SoftRow = stage_map::SoftRow;
  using Fixed = stage_map::Fixed;
  using HessianTarget = stage_map::HessianTarget;
  using Group = stage_map::Group;
  using Twin = stage_map::Twin;
  using Entry = stage_map::Entry;
  using StagePlan = stage_map::StagePlan;
  using Coupling = stage_map::Coupling;

  Lists(const SparseQp& patterns, StageStructure structure);

  // Construction, assignment to stages: stage_map_build.cpp.
  void assign_variables();
  void assign_rows(const SparseQp& patterns);
  void find_uses(const SparseQp& patterns);
  void assign_globals(const SparseQp& patterns);
  void assign_chains();
  // Construction, capacity of each stage: stage_map_plans.cpp.
  void make_plans(const SparseQp& patterns);
  void make_groups(const SparseQp& patterns, int stage, const StageStructure::Stage& given);
  void make_stages();

  // Detection of changes: stage_map_watch.cpp.
  void mark(int first, int last);
  StageFill watch(const SparseQp& qp);
  StageFill watch_soft(const SparseQp& qp, Part& part) const;
  bool hold_carried();

  // Destinations of all entries: stage_map_lists.cpp.
  void make_lists(const SparseQp& qp);
  void count_columns(StagePlan& plan);
  int column(int variable, int stage) const;
  void list_cost(int stage);
  void list_dynamics(const SparseQp& qp, int stage);
  void list_groups(const SparseQp& qp, int stage);
  int resultant_size(int stage) const;

  // Writing values along the lists: stage_map_values.cpp.
  StageFill write(const SparseQp& qp, bool with_matrices);
  bool write_matrices(const SparseQp& qp);
  void write_cost(const SparseQp& qp, int stage);
  StageFill write_dynamics(const SparseQp& qp, int stage);
  StageFill write_groups(const SparseQp& qp, int stage);
  void write_bounds(const SparseQp& qp, int stage);
  StageFill write_start(const SparseQp& qp);
  // d x_next + (row) v = rhs means x_next = scale (row) v - scale rhs.
  static double scale_of(double d) { return d == 1.0 ? -1.0 : -1.0 / d; }
  const Slack& slack_of(const Part& part) const {
    const SoftRow& soft = soft_rows[soft_of_row[part.row]];
    return part.side < 0 ? soft.below : soft.above;
  }

  // Direct rows: stage_map.cpp.
  void write_directly(SparseQp& qp, DirectRows& rows);
  void restart(const VectorXd& row_sides);
  // Destination of a row entry that belongs to no stage.
  detail::EntryTarget no_stage(int entry) {
    return {direct == nullptr ? &nowhere : aside + entry, 1.0};
  }

  // Conversion of points: stage_map_points.cpp.
  void part_to_sparse(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to);
  void to_sparse(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to);
  void to_stages(const SparseQp& qp, const PrimalDualPoint& from, StagePoint& to);
  void give_slacks(const SparseQp& qp, const StagePoint& from, PrimalDualPoint& to);
  double violation_in_stage(int stage, int group, const Part& part, const StagePoint& from) const;
  double slope_of(const SparseQp& qp, const Slack& slack, const PrimalDualPoint& at) const;
  double row_value(const SparseQp& qp, int row, const VectorXd& w) const;
  void compute_gradient(const SparseQp& qp, const PrimalDualPoint& at);
  double costate(const StagePoint& point, int stage, int x) const;

  StageStructure structure;
  int front = 0;  // number of stages inserted before the first one
  std::vector<Variable> variables;
  std::vector<int> row_stage;  // stage of groups and dynamics; -1: start rows
  std::vector<int> row_first;  // first stage of its variables
  std::vector<char> row_active;
  std::vector<SoftRow> soft_rows;
  std::vector<int> soft_of_row;  // -1: hard
  std::vector<int> start_entry;  // entries of the start rows
  std::vector<StagePlan> plans;
  std::vector<Coupling> couplings;
  std::vector<int> removable;  // inputs and globals
  int chains = 0;
  bool any_gone = false, any_fixed_value = false;
  std::vector<int> position;  // per column of a stage: work space
  StageQp stages;
  VectorXd gradient;

  DirectRows* direct = nullptr;                // null: row entries come from the sparse program
  double* aside = nullptr;                     // row entries of the sparse program, for direct rows
  double nowhere = 0.0;                        // receives entries that are not needed
  std::vector<detail::EntryTarget> targets;    // per row entry
  std::vector<HessianTarget> hessian_targets;  // per Hessian entry
  VectorXd row_values;                         // work space
};

}  // namespace saltus::qp
