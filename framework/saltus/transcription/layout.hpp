// Positions of quantities among the variables of the program.
#pragma once

#include <string>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/grid.hpp"

namespace saltus {

class BlockProgram;

/// Variables are physical values divided by their nominal magnitudes. Order: for each phase (x_0,
/// q_0, c_0, x_1, q_1, c_1, ..., x_N, q_N) with the accumulated integrals q. Unknown parameters,
/// free durations, a free start time and slacks follow.
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
