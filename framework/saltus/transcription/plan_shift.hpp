// Maps a plan to the grid of the next solve at the same absolute times, primal and dual.
//
// Nodes move between ticks, and nodes around events appear and disappear. The program's variables
// and rows keep their indices, but not their times. States and costates (multipliers of the
// dynamics) are interpolated between the old nodes. Inputs, other multipliers and slacks come from
// the old interval or node nearest in time. After its end, the plan continues with its last values.
// Phases of fixed duration move with the horizon: their plan is read across the border between
// phases without a jump. Free phases keep their end times.
#pragma once

#include <vector>

#include "saltus/core/types.hpp"

namespace saltus {

class ShootingProgram;

/// Allocates for one program at construction only.
class PlanShift {
 public:
  /// The program must outlive this object.
  explicit PlanShift(const ShootingProgram& program);

  /// Stores the times of the program's grid, with free durations from w. They are the times of the
  /// plan.
  void remember(const ShootingProgram& program, const VectorXd& w);
  /// True if the program's horizon is the stored one at a later time, with the same intervals and
  /// the same active rows and bounds. If the optimum depends on the state only, the unshifted plan
  /// is then a better guess, because a shifted plan lacks its end.
  bool is_same_horizon(const ShootingProgram& program, const VectorXd& w);
  /// Maps `plan` from the stored grid to the current grid of the program. Multipliers may be empty.
  void apply(const ShootingProgram& program, const PrimalDualPoint& plan, PrimalDualPoint& guess);

 private:
  struct Interval {
    double start = 0.0, length = 0.0;  // absolute, s; length 0: an empty slot
    double end() const { return start + length; }
  };
  // Position of an instant in the old grid.
  struct Spot {
    int phase = 0, interval = 0;
    double fraction = 0.0;
  };
  // Rows of one term in one phase, one instance per node or interval.
  struct Family {
    int phase = 0;
    bool by_node = false;
    std::vector<int> instances;
  };
  Spot find(int phase, double t, bool from_left) const;
  Spot find_across(int phase, double t, bool from_left) const;
  int nearest_node(int phase, double t) const;
  static void fill_times(const ShootingProgram& program, const VectorXd& w,
                         std::vector<std::vector<Interval>>& times);

  std::vector<std::vector<Interval>> old_;  // per phase
  long bounds_ = -1;                        // bounds revision of the stored program
  std::vector<std::vector<Interval>> new_;  // workspace
  std::vector<Family> families_;
  std::vector<int> first_instance_;    // per phase, index of its first instance among the intervals
  std::vector<char> continues_after_;  // true if the next phase continues this one
};

}  // namespace saltus
