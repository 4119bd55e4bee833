// What a planner of steps is told in every tick, and what it answers: the contacts to come.
#pragma once

#include <array>

#include "saltus/core/bounds.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus::walking {

/// A foot as it is measured.
struct FootState {
  SoleFrame sole;                                    ///< contact frame, its heading alone, m
  Vec<double, 3> velocity = Vec<double, 3>::Zero();  ///< of its origin, m/s
  bool stands = true;                                ///< on the ground
  double lifted_off = infinity;  ///< since when it swings, s; infinite: it does not. A foot that
                                 ///< neither stands nor swings hangs in the air, as at the start
                                 ///< on one foot: it may land, and need not.
  /// Whether it is in the air.
  bool swings() const { return lifted_off < infinity; }
};

/// What is known at the begin of a tick. World axes.
struct StepSituation {
  double time = 0.0;                              ///< s
  double period = 0.01;                           ///< until the planner is asked again, s
  double mass = 0.0;                              ///< of the controllers' model, kg
  double omega = 0.0;                             ///< sqrt(g / z) at the measured height z, 1/s
  Vec<double, 9> gamma = Vec<double, 9>::Zero();  ///< CoM (m), its velocity (m/s), angular
                                                  ///< momentum about it (Nms), measured
  FootState left, right;

  /// By its side.
  const FootState& foot(Side side) const { return side == Side::left ? left : right; }
  /// By its side.
  FootState& foot(Side side) { return side == Side::left ? left : right; }
};

/// One foot lifts off and lands again. Absolute times, s.
struct PlannedStep {
  Side foot = Side::right;             ///< that is put
  double lift_off = infinity;          ///< of a foot that is in the air already: any time up to now
  double landing = infinity;           ///< s
  double earliest_landing = infinity;  ///< a touch of the ground before this is not the landing
  Vec<double, 3> place = Vec<double, 3>::Zero();  ///< of its contact frame, m
};

/// A choice of feet and number of steps that was looked at.
struct StepAlternative {
  int steps = 0;             ///< how many it takes
  Side first = Side::right;  ///< the foot of the first step; means nothing without steps
  double cost = infinity;    ///< infinite: not feasible
  Vec<double, 3> place = Vec<double, 3>::Zero();  ///< of the first step, m
  double landing = infinity;                      ///< of the first step, absolute, s
};

/// How the centre of mass moves in a plan, above the ground; no samples: the planner does not say.
struct PlannedMotion {
  static constexpr int most_samples = 16;                  ///< room for them
  static constexpr double step = 0.02;                     ///< s
  double begin = 0.0;                                      ///< of the first sample, s
  int samples = 0;                                         ///< how many there are
  std::array<Vec<double, 2>, most_samples> com;            ///< m
  std::array<Vec<double, 2>, most_samples> capture_point;  ///< once the momentum is given back, m
};

/// The steps to come, soonest first; none: stand on what stands. A step whose lift-off is due
/// before the next tick begins, and is then a fact: its foot stays the first of all plans until it
/// has landed (a plan without it leaves its time and place as they were). All others may be
/// withdrawn.
struct StepPlan {
  static constexpr int most_steps = 3, most_alternatives = 8;  ///< room for them

  int count = 0;                              ///< steps of the plan
  std::array<PlannedStep, most_steps> steps;  ///< the first `count` of them

  PlannedMotion motion;  ///< of the centre of mass

  /// For the log: what was compared, and which of it was chosen (-1: there was no choice).
  int alternatives = 0;
  std::array<StepAlternative, most_alternatives> alternative;  ///< what was considered
  int chosen = -1;                                             ///< which of them; -1: none
  /// False: nothing that was compared meets all limits, and this is the least bad of it.
  bool is_feasible = true;
  double missed = 0.0;  ///< by so much in all, m; infinite: nothing was found

  /// Whether there is a step in it.
  bool is_stepping() const { return count > 0; }
};

}  // namespace saltus::walking
