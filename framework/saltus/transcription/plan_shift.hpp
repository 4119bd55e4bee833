// A plan moved on to the grid of the next solve: same absolute times, primal and dual.
//
// Between two ticks nodes move, and around an event they appear and vanish; the program's variables
// and rows keep their numbers, but not their times. States and costates (multipliers of the
// dynamics) are interpolated between the old nodes; inputs, other multipliers and slacks are those
// of the old interval or node nearest in time. Beyond its end the plan goes on with its last
// values. Phases of fixed duration move with the horizon: their plan is looked up across the border
// between them, if nothing jumps there. Free phases end at the instants at which they ended.
#pragma once

#include <vector>

#include "saltus/core/primal_dual_point.hpp"

namespace saltus {

class ShootingProgram;

/// Sized once for a program; after construction nothing allocates.
class PlanShift {
 public:
  /// The program outlives this.
  explicit PlanShift(const ShootingProgram& program);

  /// Keeps the times of the program's grid, with free durations as in w: those of the plan.
  void remember(const ShootingProgram& program, const VectorXd& w);
  /// Whether the program's horizon is the remembered one, only later: the same intervals, with the
  /// same rows and bounds in force. Where the optimum hangs on the state alone, the plan as it was
  /// is nearer to it than the plan moved on, which has no end of its own yet.
  bool is_same_horizon(const ShootingProgram& program, const VectorXd& w);
  /// `plan`, made on the remembered grid, on the program's present one. Multipliers may be empty.
  void apply(const ShootingProgram& program, const PrimalDualPoint& plan, PrimalDualPoint& guess);

 private:
  struct Interval {
    double start = 0.0, length = 0.0;  // absolute, s; length 0: an empty slot
    double end() const { return start + length; }
  };
  // Where an instant lies in the old grid.
  struct Spot {
    int phase = 0, interval = 0;
    double fraction = 0.0;
  };
  // Rows of one term in one phase, one instance per node or per interval.
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
  long bounds_ = -1;                        // revision of the remembered program's
  std::vector<std::vector<Interval>> new_;  // working memory
  std::vector<Family> families_;
  std::vector<int> first_instance_;  // of each phase among the intervals
  std::vector<char> goes_on_after_;  // whether the next phase is this one's continuation
};

}  // namespace saltus
