// Node positions: the mesh of each phase plus a node at every event, in storage of constant size.
#pragma once

#include <cstdint>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/mesh.hpp"

namespace saltus {

/// One shooting interval. Times are relative to the start of its phase and affine in the phase's
/// duration T (s): offset = offset0 + offset1 T, length = length0 + length1 T. The slopes offset1
/// and length1 are zero in phases of fixed duration.
struct GridInterval {
  double offset0 = 0.0, offset1 = 0.0;  ///< s; s per s of duration
  double length0 = 0.0, length1 = 0.0;  ///< s; s per s of duration

  /// Start of the interval for duration T, s after the start of the phase.
  double offset(double T) const { return offset0 + offset1 * T; }
  /// Length for duration T, s.
  double length(double T) const { return length0 + length1 * T; }
  /// True for an unused slot of an event that coincides with a node or lies outside the phase. Its
  /// length is zero.
  bool is_empty() const { return length0 == 0.0 && length1 == 0.0; }
};

/// A window in phase time, rounded to nodes. Empty if to <= from.
struct PhaseWindow {
  double from = 0.0;        ///< s, rounded to a node
  double to = infinity;     ///< s, rounded to a node
  std::uint64_t modes = 0;  ///< see Schedule::mask_of; 0: any mode
};

/// The intervals of all phases. The constructor fixes their number: the base intervals, plus one
/// slot per instant that a window names. If a window names a mode, it adds one slot per event of
/// the schedule's capacity. place_events() moves nodes without changing sizes.
class Grid {
 public:
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
  const GridInterval& interval(int phase, int k) const { return phases_[phase].intervals[k]; }
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
  /// seconds. This is so if it has a slot, lies outside the phase or coincides with a base node.
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
    std::vector<GridInterval> intervals;
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

}  // namespace saltus
