// Bookkeeping of ShootingProgram: the blocks, rows and slacks of each term at each grid point.
#pragma once

#include <vector>

namespace saltus::shooting {

/// A grid point at which a function of (t, x, u, p) is evaluated.
struct GridPoint {
  int phase = 0;        ///< index of the phase
  int node = 0;         ///< node of the state
  int interval = -1;    ///< interval of the input, or -1
  bool at_end = false;  ///< input at the end of the interval instead of its start
};

/// A block with the sources of its data arguments.
struct BlockInstance {
  int block = -1;               ///< index in the program
  GridPoint point;              ///< position on the grid
  int time_argument = -1;       ///< index of t (or t0)
  int length_argument = -1;     ///< index of h, or -1
  int parameter_argument = -1;  ///< index of the first parameter, or -1
  int duration_argument = -1;   ///< index of the phase's duration, or -1
};

/// A constraint term at one grid point.
struct RowInstance {
  int phase = 0, term = 0;                    ///< indices of phase and term
  BlockInstance block;                        ///< evaluates the term
  bool state_only = true;                     ///< true if the term reads no inputs
  std::vector<bool> reads_states_alone;       ///< per output
  int first_row = 0;                          ///< first row in the program
  std::vector<int> slack_below, slack_above;  ///< variables per component, or -1
  std::vector<int> slack_free;  ///< free slacks of penalties that have one (Penalty::Slacks)
};

/// Rows of a link, or of an integral at the end of a phase.
struct LimitInstance {
  int phase = 0;                 ///< phase in the report: that of the latest end
  GridPoint point;               ///< grid point of the latest end
  int link = -1;                 ///< index of the link, or -1
  int integral = -1;             ///< index of the integral in the phase, or -1
  int first_row = 0, count = 1;  ///< rows in the program
  std::vector<int> slack_below, slack_above, slack_free;  ///< see RowInstance
};

/// A cost term at one grid point: an output of a block.
struct CostInstance {
  int phase = 0, term = 0;     ///< indices of phase and term
  int interval = -1;           ///< -1: at an end of the phase
  int block = -1, output = 0;  ///< block in the program, and its output
  bool length_inside = false;  ///< the block multiplies by the interval length itself
  int switch_argument = -1;    ///< index of the argument that switches the cost off, or -1
};

/// Cost of the input change from interval `from` to `to`. `from` is -1 for the input applied before
/// the first interval.
struct ChangeInstance {
  int phase = 0, from = -1, to = 0;  ///< the phase and both intervals
  int block = -1;                    ///< index in the program
};

/// The block of a link that is a cost.
struct LinkCost {
  int link = -1, phase = 0;  ///< index of the link and of the latest phase that it reads
  int block = -1;            ///< index in the program
};

/// Rows that connect an interval to its successor.
struct IntervalInstance {
  int phase = 0, interval = 0;  ///< indices of phase and interval
  int first_row = 0;            ///< first row of the defect
  int continuity_row = -1;      ///< continuity of continuous and held inputs, or -1
  int slope_row = -1;           ///< slope of held ramps, or -1
  int integral_row = -1;        ///< first row that continues the integrals, or -1
  int block = -1;               ///< block of the flow
};

}  // namespace saltus::shooting
