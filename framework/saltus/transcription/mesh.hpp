// Where the nodes of a phase stand before events add theirs: equal intervals, or finer ones where
// it matters.
#pragma once

#include <string>
#include <vector>

namespace saltus {

/// How a phase is cut into intervals.
struct Mesh {
  int intervals = 30;  ///< how many
  /// Fractions of the phase's duration at which the nodes stand, rising from 0 to 1, one more than
  /// intervals; empty: intervals of equal length.
  std::vector<double> nodes = {};
  /// Per node, whether the input goes on through it, constant or along its ramp. Such a node lets
  /// the rows of path constraints look inside an input's interval and gives the inputs no more
  /// freedom. Ramps go on between intervals of equal length. Empty: no node does.
  std::vector<char> holds = {};

  /// Whether the input goes on over this node.
  bool holds_input(int node) const { return !holds.empty() && holds[node] != 0; }
  /// The fraction at which a node stands.
  double fraction(int node) const;

  /// What one input acts on: an interval, or several with held nodes between them.
  struct InputInterval {
    int first = 0, count = 1;  ///< intervals
  };
  /// The intervals of inputs, in their order.
  std::vector<InputInterval> input_intervals() const;
  /// What becomes of an input interval: `pieces` equal intervals in all, with one input if it
  /// holds.
  struct Cut {
    int pieces = 1;      ///< intervals that come of this one
    bool holds = false;  ///< whether the input goes on over the new nodes
  };
  /// With every interval cut as said, one cut per interval.
  Mesh divided(const std::vector<Cut>& cuts) const;
  /// Throws DefinitionError, naming the phase, if this is no mesh.
  void check(const std::string& phase) const;
};

/// Intervals whose lengths grow by the same factor from each to the next, `ratio` between the last
/// and the first: short ones at the start (ratio above 1) or at the end (below). Throws
/// DefinitionError if the ratio is not positive.
Mesh graded_mesh(int intervals, double ratio);
/// Short intervals at both ends, `ratio` times longer ones in the middle.
Mesh mesh_graded_to_both_ends(int intervals, double ratio);

}  // namespace saltus
