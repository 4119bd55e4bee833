// Where a quantity stands among the variables of the program.
#pragma once

#include <string>
#include <vector>

#include "saltus/ocp/problem.hpp"
#include "saltus/transcription/grid.hpp"

namespace saltus {

class BlockProgram;

/// Variables of the program are physical values divided by their nominal magnitudes. Order: phase
/// by phase (x_0, q_0, c_0, x_1, q_1, c_1, ..., x_N, q_N) with the integrals q so far, then unknown
/// parameters, free durations, a free start time, slacks.
class Layout {
 public:
  /// Declares all variables in `program`.
  Layout(const OptimalControlProblem& problem, const Grid& grid, BlockProgram& program);

  /// First state of a node; node = intervals is the end of the phase (before the jump).
  int state(int phase, int node) const { return phases_[phase].states[node]; }
  /// First of the phase's integrals (PhaseDefinition::integrals) up to a node.
  int integral(int phase, int node) const { return phases_[phase].integrals[node]; }
  /// First coefficient of the input of an interval.
  int input(int phase, int interval) const { return phases_[phase].inputs[interval]; }
  /// Duration of the phase, or -1 if it is fixed.
  int duration(int phase) const { return phases_[phase].duration; }
  /// Time of the start, or -1 if it is given.
  int start_time() const { return start_time_; }
  /// Entry i of the phase's parameters, or -1 if it is data.
  int parameter(int phase, int i) const { return phases_[phase].parameters[i]; }
  /// Variables from here on are slacks of soft constraints.
  void set_first_slack(int first) { first_slack_ = first; }

  /// "phase 'flight', node 3, state 1", for messages.
  std::string describe(int variable) const;

 private:
  struct PhaseLayout {
    std::vector<int> states, integrals, inputs, parameters;
    int duration = -1;
  };
  std::vector<PhaseLayout> phases_;
  std::vector<std::string> names_;  // of variables, per block start
  std::vector<int> starts_;
  int start_time_ = -1;
  int first_slack_ = 0;
};

}  // namespace saltus
