// Node positions: the mesh of each phase plus a node at every event, in storage of constant size.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "saltus/core/bounds.hpp"
#include "saltus/core/types.hpp"
#include "saltus/ocp/problem.hpp"
#include "saltus/ocp/schedule.hpp"

namespace saltus {

// All data that may change between two solves of a transcribed problem, as one value.

/// Data of a solve. ShootingProgram::commit applies all of it or nothing.
struct ProblemData {
  double start_time = 0.0;              ///< absolute, s
  std::vector<Bounds> start_bounds;     ///< bounds of the first state; equal sides if it is fixed
  std::vector<double> durations;        ///< per phase, s; initial guess if free
  std::vector<Bounds> duration_bounds;  ///< per phase, s; ignored for fixed durations
  Bounds total_time;                    ///< s; used if the problem bounds it
  std::vector<VectorXd> parameters;     ///< p of each phase: data, and initial guesses of unknowns
  VectorXd previous_input;              ///< applied before the horizon; NaN: unknown, not charged
  Schedule schedule;                    ///< events and modes of the next solve

  ProblemData() = default;
  /// Data from the problem definition.
  explicit ProblemData(const OptimalControlProblem& problem);

  /// True if the first state is fixed.
  bool has_given_start() const;
  /// True if both give the same node times and the same bounds on durations.
  bool has_same_times(const ProblemData& other) const;
};

/// Throws DefinitionError with the item if a size is wrong, a number is invalid or an event of a
/// window is missing. Contradictory bounds are detected on the grid only. Allocates only if
/// it throws.
void check(const OptimalControlProblem& problem, const ProblemData& data);

// Node positions of a phase before events add nodes: equal intervals or a graded mesh.

/// Division of a phase into intervals.
struct Mesh {
  static constexpr int most_intervals = 1'000'000;  ///< limit per phase

  int intervals = 30;  ///< number of intervals
  /// Node positions as fractions of the phase's duration, increasing from 0 to 1, intervals + 1
  /// entries. Empty: intervals of equal length.
  std::vector<double> nodes = {};
  /// Flag per node: true if the input continues across it, constant or along its ramp. Such a node
  /// adds rows of path constraints inside an input interval without more freedom for the inputs.
  /// Ramps continue only between intervals of equal length. Empty: no node holds the input.
  std::vector<char> holds = {};

  /// True if the input continues across this node.
  bool holds_input(int node) const { return !holds.empty() && holds[node] != 0; }
  /// Position of a node as a fraction.
  double fraction(int node) const;

  /// The range of one input: an interval, or several intervals separated by held nodes.
  struct InputInterval {
    int first = 0, count = 1;  ///< first interval, and number of intervals
  };
  /// The input intervals in order.
  std::vector<InputInterval> input_intervals() const;
  /// Division of an input interval into `pieces` equal intervals in total. They share one input if
  /// `holds` is true.
  struct Cut {
    int pieces = 1;      ///< number of new intervals
    bool holds = false;  ///< true: the input continues across the new nodes
  };
  /// The mesh with every interval cut, one Cut per interval.
  Mesh divided(const std::vector<Cut>& cuts) const;
  /// Throws DefinitionError with the phase if the mesh is invalid.
  void check(const std::string& phase) const;
};

/// Intervals whose lengths grow geometrically. `ratio` is the length of the last divided by the
/// first: above 1 gives short intervals at the start, below 1 at the end. Throws DefinitionError if
/// the ratio is not positive.
Mesh graded_mesh(int intervals, double ratio);
/// Short intervals at both ends. Intervals in the middle are `ratio` times longer.
Mesh mesh_graded_to_both_ends(int intervals, double ratio);

/// The intervals of all phases. The constructor fixes their number: the base intervals, plus one
/// slot per instant that a window names. If a window names a mode, it adds one slot per event of
/// the schedule's capacity. place_events() moves nodes without changing sizes.
class Grid {
 public:
  /// One shooting interval. Times are relative to the start of its phase and affine in the phase's
  /// duration T (s): offset = offset0 + offset1 T, length = length0 + length1 T. The slopes offset1
  /// and length1 are zero in phases of fixed duration.
  struct Interval {
    double offset0 = 0.0, offset1 = 0.0;  ///< s; s per s of duration
    double length0 = 0.0, length1 = 0.0;  ///< s; s per s of duration

    /// Start of the interval for duration T, s after the start of the phase.
    double offset(double T) const { return offset0 + offset1 * T; }
    /// Length for duration T, s.
    double length(double T) const { return length0 + length1 * T; }
    /// True for an unused slot of an event that coincides with a node or lies outside the phase.
    /// Its length is zero.
    bool is_empty() const { return length0 == 0.0 && length1 == 0.0; }
  };

  /// A window in phase time, rounded to nodes. Empty if to <= from.
  struct PhaseWindow {
    double from = 0.0;        ///< s, rounded to a node
    double to = infinity;     ///< s, rounded to a node
    std::uint64_t modes = 0;  ///< see Schedule::mask_of; 0: any mode
  };

  /// Takes one mesh per phase. Throws DefinitionError if a mesh is invalid. Also throws if a window
  /// refers to absolute time, or may end outside its phase, while the start or duration of the
  /// phase is unknown.
  Grid(const OptimalControlProblem& problem, const std::vector<Mesh>& meshes);

  /// Number of phases.
  int phases() const { return static_cast<int>(phases_.size()); }
  /// Intervals of a phase, including event slots.
  int intervals(int phase) const { return static_cast<int>(phases_[phase].intervals.size()); }
  /// Intervals of a phase before events split them.
  int base_intervals(int phase) const { return phases_[phase].mesh.intervals; }
  /// Interval k of a phase.
  const Interval& interval(int phase, int k) const { return phases_[phase].intervals[k]; }
  /// Mean length of a base interval, s: duration / base intervals.
  double nominal_length(int phase) const;
  /// Fixed duration, or the initial guess of a free one, s.
  double reference_duration(int phase) const { return phases_[phase].duration; }
  /// True if the input may change at this node because an event or a window limit is there.
  bool is_event(int phase, int node) const { return phases_[phase].event_node[node]; }

  /// True if some inputs of the phase span several intervals.
  bool has_held_inputs(int phase) const { return !phases_[phase].mesh.holds.empty(); }
  /// True if the input of the interval before the node continues after it (Mesh::holds).
  bool holds_input(int phase, int node) const {
    return phases_[phase].held_node[node] && !is_event(phase, node);
  }

  /// Recomputes the nodes of fixed phases for new event times or a new start time. Does not
  /// allocate.
  void place_events(const Schedule& schedule, double start_time);
  /// Sets another duration (s) of a fixed phase for the next place_events(). Window limits that
  /// coincided with a node have no slot: check has_node_at().
  void set_duration(int phase, double duration) { phases_[phase].duration = duration; }

  /// True if a window limit in phase time (s) is a node when the fixed phase lasts `duration`
  /// seconds: it has a slot, lies outside the phase or coincides with a base node.
  bool has_node_at(int phase, double limit, double duration) const;

  /// Throws DefinitionError with phase, term and event if a window names an event that is not in
  /// the schedule.
  static void check_events(const OptimalControlProblem& problem, const Schedule& schedule);

  /// The window in phase time, rounded to nodes.
  PhaseWindow resolve(int phase, const Window& window) const;
  /// For running costs and inputs: true if the interval lies in [from, to). Empty intervals are in
  /// no window.
  bool interval_in(int phase, int k, const PhaseWindow& window) const;
  /// For constraints on states: true if from <= node <= to, with the right end as a left limit. Of
  /// several nodes at the same instant, only the last counts, also at the end of the phase.
  bool node_in(int phase, int node, const PhaseWindow& window) const;
  /// Offset of a node at the reference duration, s.
  double node_offset(int phase, int node) const;

 private:
  struct PhaseGrid {
    Mesh mesh;
    bool is_free = false;
    bool has_known_start = true;
    double duration = 0.0;
    double start = 0.0;           // absolute, s, if known
    std::vector<Instant> slots;   // instants with a separate slot
    std::vector<Clock> clocks;    // clock of each slot
    std::vector<double> marks;    // fixed instants at base nodes
    bool has_modes = false;       // every event of the current schedule splits an interval
    std::vector<double> cuts;     // event times: rounded to nodes inside the phase
    std::vector<double> offsets;  // node offsets at the reference duration
    std::vector<char> event_node;
    std::vector<char> held_node;
    std::vector<Interval> intervals;
  };

  void collect_instants(const PhaseDefinition& phase, PhaseGrid& grid) const;
  void place_fixed(PhaseGrid& grid);
  static double insert_node(PhaseGrid& grid, std::size_t& count, double at);
  template <class Visit>
  bool any_span(const PhaseGrid& grid, const PhaseWindow& window, Visit&& visit) const;
  void place_free(PhaseGrid& grid, const PhaseDefinition& phase);
  double instant_offset(const PhaseGrid& grid, const Instant& instant, Clock clock) const;
  static double snap(const PhaseGrid& grid, double offset);
  static double base_offset(const Mesh& mesh, double duration, int node);
  static double nearest_base_offset(const Mesh& mesh, double duration, double offset);

  Schedule schedule_;
  std::vector<PhaseGrid> phases_;
};
/// Deprecated name.
using GridInterval [[deprecated("use Grid::Interval; removed in 0.4")]] = Grid::Interval;
/// Deprecated name.
using PhaseWindow [[deprecated("use Grid::PhaseWindow; removed in 0.4")]] = Grid::PhaseWindow;

// Positions of quantities among the variables of the program.

class BlockProgram;

/// Positions of all quantities in the vector of variables. Variables are physical values divided by
/// their nominal magnitudes. Order: for each phase (x_0, q_0, c_0, x_1, q_1, c_1, ..., x_N, q_N)
/// with the accumulated integrals q. Unknown parameters, free durations, a free start time and
/// slacks follow.
class Layout {
 public:
  /// Adds all variables to `program`.
  Layout(const OptimalControlProblem& problem, const Grid& grid, BlockProgram& program);

  /// First state of a node. node = intervals is the end of the phase (before the jump).
  int state(int phase, int node) const { return phases_[phase].states[node]; }
  /// First of the phase's integrals (PhaseDefinition::integrals), accumulated up to a node.
  int integral(int phase, int node) const { return phases_[phase].integrals[node]; }
  /// First input coefficient of an interval.
  int input(int phase, int interval) const { return phases_[phase].inputs[interval]; }
  /// Duration of the phase, or -1 if it is fixed.
  int duration(int phase) const { return phases_[phase].duration; }
  /// Start time, or -1 if it is fixed.
  int start_time() const { return start_time_; }
  /// Entry i of the phase's parameters, or -1 if it is data.
  int parameter(int phase, int i) const { return phases_[phase].parameters[i]; }
  /// Declares that variables from this index on are slacks of soft constraints.
  void set_first_slack(int first) { first_slack_ = first; }

  /// Text for messages: "phase 'flight', node 3, state 1".
  std::string describe(int variable) const;

 private:
  struct PhaseLayout {
    std::vector<int> states, integrals, inputs, parameters;
    int duration = -1;
  };
  std::vector<PhaseLayout> phases_;
  std::vector<std::string> names_;  // names of blocks of variables
  std::vector<int> starts_;
  int start_time_ = -1;
  int first_slack_ = 0;
};

}  // namespace saltus
