// Input and output of a step planner: the situation in a tick and the planned contacts.
#pragma once

#include <array>

#include "saltus/core/bounds.hpp"
#include "saltus/robots/model/foot.hpp"

namespace saltus::walking {

/// Measured state of a foot.
struct FootState {
  SoleFrame sole;  ///< contact frame, levelled, with the heading of the foot, m
  Vec<double, 3> velocity = Vec<double, 3>::Zero();  ///< velocity of its origin, m/s
  bool stands = true;                                ///< true if on the ground
  double lifted_off = infinity;  ///< start of the swing, s; infinite: not swinging. A foot that
                                 ///< neither stands nor swings is in the air, as at the start on
                                 ///< one foot. It may land but need not.
  /// True if the foot swings.
  bool swings() const { return lifted_off < infinity; }
};

/// Measured situation at the start of a tick, in world axes.
struct StepSituation {
  double time = 0.0;                              ///< s
  double period = 0.01;                           ///< time until the next call, s
  double mass = 0.0;                              ///< mass of the controllers' model, kg
  double omega = 0.0;                             ///< sqrt(g / z) at the measured height z, 1/s
  Vec<double, 9> gamma = Vec<double, 9>::Zero();  ///< measured CoM (m), its velocity (m/s), angular
                                                  ///< momentum about it (Nms)
  FootState left, right;

  /// State of the foot on the given side.
  const FootState& foot(Side side) const { return side == Side::left ? left : right; }
  /// State of the foot on the given side.
  FootState& foot(Side side) { return side == Side::left ? left : right; }
};

/// One step: a foot lifts off and lands again. Absolute times, s.
struct PlannedStep {
  Side foot = Side::right;     ///< foot that steps
  double lift_off = infinity;  ///< for a foot that is in the air already: any time up to now
  double landing = infinity;   ///< s
  double earliest_landing = infinity;  ///< an earlier contact does not count as the landing
  Vec<double, 3> place = Vec<double, 3>::Zero();  ///< place of its contact frame, m
};

/// A candidate: first foot and number of steps.
struct StepAlternative {
  int steps = 0;             ///< number of steps
  Side first = Side::right;  ///< foot of the first step; meaningless without steps
  double cost = infinity;    ///< infinite: not feasible
  Vec<double, 3> place = Vec<double, 3>::Zero();  ///< place of the first step, m
  double landing = infinity;                      ///< landing of the first step, absolute, s
};

/// Horizontal motion of the CoM in a plan. Without samples the planner gives none.
struct PlannedMotion {
  static constexpr int most_samples = 16;                  ///< capacity
  static constexpr double step = 0.02;                     ///< sampling time, s
  double begin = 0.0;                                      ///< time of the first sample, s
  int samples = 0;                                         ///< number of samples
  std::array<Vec<double, 2>, most_samples> com;            ///< m
  std::array<Vec<double, 2>, most_samples> capture_point;  ///< after the momentum has returned to
                                                           ///< zero, m
};

/// Planned steps, soonest first. Without steps the robot stays on its present feet. A step whose
/// lift-off is due before the next tick begins and is then fixed. Its foot stays the first of all
/// plans until it has landed; a plan without it keeps its time and place. All other steps may be
/// withdrawn.
struct StepPlan {
  static constexpr int most_steps = 3, most_alternatives = 8;  ///< capacities

  int count = 0;                              ///< number of steps
  std::array<PlannedStep, most_steps> steps;  ///< the first `count` of them

  PlannedMotion motion;  ///< motion of the CoM

  /// For the log: candidates that were compared.
  int alternatives = 0;
  std::array<StepAlternative, most_alternatives> alternative;  ///< the candidates
  int chosen = -1;  ///< index of the chosen candidate; -1: none
  /// False if no candidate meets all limits and this is the one with the smallest violation.
  bool is_feasible = true;
  double missed = 0.0;  ///< total violation, m; infinite: nothing was found

  /// True if the plan contains a step.
  bool is_stepping() const { return count > 0; }
};

}  // namespace saltus::walking
