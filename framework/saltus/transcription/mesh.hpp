// Node positions of a phase before events add nodes: equal intervals or a graded mesh.
#pragma once

#include <string>
#include <vector>

namespace saltus {

/// Division of a phase into intervals.
struct Mesh {
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

}  // namespace saltus
