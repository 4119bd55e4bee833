// Bookkeeping of ShootingProgram: which block, row and slack stands for which term where.
#pragma once

#include <vector>

namespace saltus::shooting {

/// A point of the grid at which a function of (t, x, u, p) is evaluated.
struct GridPoint {
  int phase = 0;        ///< which one
  int node = 0;         ///< whose state is used
  int interval = -1;    ///< whose input is used; -1: none
  bool at_end = false;  ///< the input at the end of the interval rather than at its start
};

/// A block together with where its data arguments come from.
struct BlockInstance {
  int block = -1;               ///< of the program
  GridPoint point;              ///< where on the grid
  int time_argument = -1;       ///< index of t (or t0)
  int length_argument = -1;     ///< index of h, -1: none
  int parameter_argument = -1;  ///< index of the first parameter, -1: none
  int duration_argument = -1;   ///< index of the phase's duration, -1: none
};

/// A constraint term at one point.
struct RowInstance {
  int phase = 0, term = 0;                    ///< which phase and term
  BlockInstance block;                        ///< what evaluates it
  bool state_only = true;                     ///< reads no inputs
  std::vector<bool> reads_state;              ///< per output
  int first_row = 0;                          ///< of the program
  std::vector<int> slack_below, slack_above;  ///< variables per component, -1: none
  std::vector<int> slack_free;                ///< of penalties that have one (PenaltySlacks)
};

/// Rows that belong to no term of a phase: a link, or what an integral has come to at the end of a
/// phase.
struct LimitInstance {
  int phase = 0;                 ///< in which it is reported: that of the latest end
  GridPoint point;               ///< of the latest end
  int link = -1;                 ///< of the problem, or
  int integral = -1;             ///< of the phase
  int first_row = 0, count = 1;  ///< of the program
  std::vector<int> slack_below, slack_above, slack_free;  ///< as in RowInstance
};

/// A cost term at one grid point: an output of a block.
struct CostInstance {
  int phase = 0, term = 0;     ///< which phase and term
  int interval = -1;           ///< -1: at one end of the phase
  int block = -1, output = 0;  ///< of the program, and which of its outputs
  bool length_inside = false;  ///< the block multiplies by the length itself
  int switch_argument = -1;    ///< index of the argument that leaves the cost out, -1: none
};

/// Input-change cost of interval `to` against interval `from` (-1: the input applied before).
struct ChangeInstance {
  int phase = 0, from = -1, to = 0;  ///< the phase, the interval before and the one behind
  int block = -1;                    ///< of the program
};

/// The rows that join an interval to what follows it.
struct IntervalInstance {
  int phase = 0, interval = 0;  ///< which ones
  int first_row = 0;            ///< of the defect
  int continuity_row = -1;      ///< of continuous and of held inputs, -1: none
  int slope_row = -1;           ///< of held ramps, -1: none
  int integral_row = -1;        ///< first of those that continue the integrals, -1: none
  int block = -1;               ///< of the flow
};

}  // namespace saltus::shooting
