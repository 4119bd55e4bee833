// Where the nodes stand: the mesh of each phase plus a node exactly at every event, in storage of
// constant size.
#pragma once

#include <cstdint>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/mesh.hpp"

namespace saltus {

/// One shooting interval. Times count from the start of its phase and are affine in the phase's
/// duration T (s): offset = offset0 + offset1 T, length = length0 + length1 T. In phases of fixed
/// duration the slopes are zero.
struct GridInterval {
  double offset0 = 0.0, offset1 = 0.0;  ///< s, and s per s of duration
  double length0 = 0.0, length1 = 0.0;  ///< s, and s per s of duration

  /// From the start of the phase for duration T, s.
  double offset(double T) const { return offset0 + offset1 * T; }
  /// For duration T, s.
  double length(double T) const { return length0 + length1 * T; }
  /// A slot kept for an event that coincides with a node or lies outside the phase: no time passes.
  bool is_empty() const { return length0 == 0.0 && length1 == 0.0; }
};

/// A window in phase time after rounding to nodes; empty when to <= from.
struct PhaseWindow {
  double from = 0.0;        ///< s, rounded to a node
  double to = infinity;     ///< s, rounded to a node
  std::uint64_t modes = 0;  ///< bits of Schedule::mask_of; 0: whatever the mode
};

/// Intervals of all phases. The number per phase is fixed at construction: the base intervals and
/// one slot for every instant a window names; where a window names a mode, one slot for every event
/// that the schedule has room for. place_events() moves the events, never the sizes.
class Grid {
 public:
  /// One mesh per phase. Throws DefinitionError when a mesh is none, or a window of a phase with
  /// unknown start or duration refers to absolute time or may lie beyond the phase.
  Grid(const OptimalControlProblem& problem, const std::vector<Mesh>& meshes);

  /// How many.
  int phases() const { return static_cast<int>(phases_.size()); }
  /// Of a phase, slots of events included.
  int intervals(int phase) const { return static_cast<int>(phases_[phase].intervals.size()); }
  /// Of a phase, before events cut them.
  int base_intervals(int phase) const { return phases_[phase].mesh.intervals; }
  /// Interval k of a phase.
  const GridInterval& interval(int phase, int k) const { return phases_[phase].intervals[k]; }
  /// Mean length of an interval before events cut it: duration over base intervals (s).
  double nominal_length(int phase) const;
  /// Fixed duration, or the guess of a free one (s).
  double reference_duration(int phase) const { return phases_[phase].duration; }
  /// Whether a control break is due at node k because an event or window limit stands there.
  bool is_event(int phase, int node) const { return phases_[phase].event_node[node]; }

  /// Whether inputs of a phase go on over several intervals.
  bool has_held_inputs(int phase) const { return !phases_[phase].mesh.holds.empty(); }
  /// Whether the input of the interval that ends at the node goes on in the next (Mesh::holds).
  bool holds_input(int phase, int node) const {
    return phases_[phase].held_node[node] && !is_event(phase, node);
  }

  /// Recomputes the nodes of fixed phases for new event times or a new start time. No allocation.
  void place_events(const Schedule& schedule, double start_time);
  /// Another duration (s) of a fixed phase, for the next place_events(). Limits of windows that
  /// stood on a node have no slot: ask has_node_at().
  void set_duration(int phase, double duration) { phases_[phase].duration = duration; }

  /// Whether a limit of a window in phase time (s) is a node if the fixed phase lasts `duration`
  /// (s): it has a slot, is no longer inside, or a base node stands there.
  bool has_node_at(int phase, double limit, double duration) const;

  /// Throws DefinitionError, naming phase, term and event, when a window names an event that is
  /// not in the schedule.
  static void check_events(const OptimalControlProblem& problem, const Schedule& schedule);

  /// A window in phase time, rounded to nodes.
  PhaseWindow resolve(int phase, const Window& window) const;
  /// Running costs and inputs: the interval lies in [from, to). Empty intervals are in no window.
  bool interval_in(int phase, int k, const PhaseWindow& window) const;
  /// Constraints on states: from <= node <= to, the right end as a left limit. Of nodes at the
  /// same instant only the last counts, at the end of the phase too.
  bool node_in(int phase, int node, const PhaseWindow& window) const;
  /// Offset of a node at the reference duration (s).
  double node_offset(int phase, int node) const;

 private:
  struct PhaseGrid {
    Mesh mesh;
    bool is_free = false;
    bool has_known_start = true;
    double duration = 0.0;
    double start = 0.0;           // absolute, if known
    std::vector<Instant> slots;   // instants with a slot of their own
    std::vector<Clock> clocks;    // of each slot
    std::vector<double> marks;    // fixed instants that coincide with base nodes
    bool has_modes = false;       // every event of the live schedule cuts
    std::vector<double> cuts;     // where they do, rounded to nodes; outside the phase as they are
    std::vector<double> offsets;  // of the nodes, at the reference duration
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
